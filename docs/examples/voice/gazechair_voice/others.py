"""Words that are no command: frequent ones of the recogniser's language model.

Without those that resembled a command in trials with synthetic voices.
"""

_WORDS = """
about according across after age amazing america american another answer anyone anything anyway as
ask at available average awesome baby back bad based basically be because before behind being best
better between big bit black books box brother bus business but buy by came car case certain
certainly chance change changed check city class coffee community companies computer could
countries country course crazy dad day days dead decided did different difficult do does drive
each easy eat economy education eight eighty either eleven enough er ever every everybody everyone
exactly example expect face fact fast father feeling few fifteen fifty fight figure find fire
first fish five food forty friends from front fuck fucking fun funny future game games gave
general get gets getting give given guess guy guys had half happen happened happens happy hard has
hate have having he head hear heard heart her here hey hi high higher his history hit hot hours
house human hungry husband if imagine important inside instead internet into iraq is issue issues
it its just keep kid kids kind kinda kitchen large last less letter like listen look looking looks
major makes making market married matter mean means media military morning mother movie mr much
must myself need needed needs never news next nice ninety nothing number obama obviously office
once one ones order other others outside paid part party past pay per percent perhaps person
personal pick places point political possible president pretty price private probably problem
problems process public put question questions quite rather reading ready reality reason research
rest risk running said say saying says season second security see seeing seem seems seen sense
service set seven seventy sex she shit should shower side similar simply since single sister sit
situation six sixty some somebody someone something sometimes son soon sorry soup space spend
spent sports start state states stay story street students study stuff such summer support
supposed sure system take taken takes taking tea team test thank thanks that these things think
thinking third thirty this thousand time times today together tomorrow too took tried true try
trying turn turned twenty two type under unless up us using usually very wanted wants wash
watching water weather weeks went were whatever whether which white who window without wonder word
words work worked working works worse worth would yeah yesterday yourself zero
"""
OTHERS = _WORDS.split()
