# The pages of gazechair as plain files; lets Python find them when installed as package gazeweb.
