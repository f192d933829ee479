"""Members of which all but what they find along motions is made up."""

from types import SimpleNamespace

from gelcone.physics.members import Members


class MadeUp(SimpleNamespace):
    """Members of a system without numbers, unless others are given."""

    along = Members.along

    def numbers(self, trailing):
        return {}
