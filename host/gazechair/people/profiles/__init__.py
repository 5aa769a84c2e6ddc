"""Driver profiles: what a person has set for themselves, stored on the host."""

from gazechair.people.profiles.fields import ProfileRefused, fields
from gazechair.people.profiles.house import house_fields
from gazechair.people.profiles.store import Profiles

__all__ = ["ProfileRefused", "Profiles", "fields", "house_fields"]
