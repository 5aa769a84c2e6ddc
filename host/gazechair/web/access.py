"""Access to the host: the pairing desk, the command line's local socket, the web server."""

from __future__ import annotations

from gazechair.base.health import Health
from gazechair.base.state_folder import state_folder
from gazechair.config.settings import Config
from gazechair.people.pairing import PairingDesk, StoreError
from gazechair.people.pairing.local import LocalDoor
from gazechair.people.pairing.one_time import VALID_S
from gazechair.people.pairing.show import code_as_text
from gazechair.web import PageParts, WebError, WebServer


class Access:
    """All access for people's devices to the host."""

    def __init__(self, config: Config, parts: PageParts, devices: Health | None = None) -> None:
        """`devices`: the health of the list of paired devices."""
        self._config = config
        self._parts = parts
        self._devices = devices
        self._desk: PairingDesk | None = None
        self._web: WebServer | None = None
        self._side: LocalDoor | None = None

    @property
    def url(self) -> str:
        """The pages' address; "" while it is not open."""
        if self._web is None:
            return ""
        language = self._config.web.language
        return self._web.url + ("" if language == "nl" else f"?lang={language}")

    def start(self) -> None:
        """Open. Raises WebError: state folder, certificate, address or files."""
        folder = state_folder(self._config.web.state_folder)
        try:
            self._desk = PairingDesk(folder, health=self._devices)
            self._web = WebServer(self._config, self._parts, self._desk, folder)
            self._side = LocalDoor(self._desk, folder, self._pairing_url)
            self._side.start()
        except StoreError as error:
            raise WebError(str(error)) from error
        self._web.start()

    def stop(self) -> None:
        """Disconnect everyone and close. Safe to call when start failed."""
        if self._web is not None:
            self._web.stop()
        if self._side is not None:
            self._side.stop()

    def invitation(self) -> str:
        """A code for the driver's device while there is none; "" when there is one."""
        if self._desk is None or any(d.role == "driver" for d in self._desk.devices()):
            return ""
        code = self._desk.new_code("driver")
        return code_as_text(self._pairing_url(), code.text, code.role, VALID_S)

    def _pairing_url(self) -> str:
        return "" if self._web is None else f"{self._web.url}pair"
