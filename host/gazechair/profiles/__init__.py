"""Who drives: each person's own times, looks and language, kept on the host."""

from gazechair.profiles.fields import ProfileRefused, fields
from gazechair.profiles.house import house_fields
from gazechair.profiles.store import Profiles

__all__ = ["ProfileRefused", "Profiles", "fields", "house_fields"]
