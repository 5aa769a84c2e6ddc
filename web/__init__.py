# The pages of gazechair as plain files; this lets Python find them when installed as package gazeweb.
