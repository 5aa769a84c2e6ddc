"""A person with one switch before the driver's page."""

from patience import wait_until
from webperson import Driver

DIRECTIONS = ["forward", "left", "right"]
ROWS = {"scan": "rows", "scan_ms": 1000}
LIT = "() => [...document.querySelectorAll('.lit')].map(e => e.id)"


class Scanner(Driver):
    """A person with one switch before the page."""

    key = " "

    def lit(self):
        return self.page.evaluate(LIT)

    def down(self):
        self.page.keyboard.down(self.key)

    def up(self):
        self.page.keyboard.up(self.key)

    def press(self, ms=100):
        self.down()
        self.advance(ms)
        self.up()
        self.advance(50)

    def wait_for(self, *names):
        """Waits until these are lit and were seen, and until a press counts again."""
        self.advance(350)
        for _ in range(100):
            if self.lit() == list(names):
                return self.advance(75)
            self.advance(200)
        raise AssertionError(f"{names} are never lit, but {self.lit()}")

    def choose(self, *way):
        """Presses when each of these is lit, the last of which stays pressed."""
        for step in way[:-1]:
            self.wait_for(*step)
            self.press()
        self.wait_for(*way[-1])
        self.down()
        self.advance(100)

    def sent(self):
        """What moved or stopped since the last call, without repetitions."""
        kinds = [(m["k"], m.get("verb"), m.get("edge")) for m in self.received("cmd", "stop")]
        self.forget()
        return [kind for n, kind in enumerate(kinds) if n == 0 or kinds[n - 1] != kind]


def opened(page, host, **requests):
    host.profiles.change({"save": {"id": "1", **ROWS, **requests}}, True)
    person = Scanner(page, host)
    person.open()
    wait_until(person.lit, "the scan")
    person.forget()
    return person
