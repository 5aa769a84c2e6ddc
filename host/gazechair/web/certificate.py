"""The host's own certificate, created once with the `openssl` command.

It is kept in the state folder. A local authority signs it, and the authority's key is then deleted:
a tablet that trusts this authority trusts this one certificate, and nobody can ever make another.
Both are valid for 820 days; iOS accepts 825. A clock that nobody set and that is far off gives no
dates, and renews nothing. One that was ahead unnoticed is: a certificate with dates of a clock that
nobody set is replaced at a start before they begin.
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import os
import shutil
import ssl
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from gazechair.base.clock import EARLIEST_S, is_set
from gazechair.base.state_folder import set_aside

DAYS = 820
_DAY_S = 86_400
_RENEW_S = 14 * _DAY_S
_BELIEVED_S = 366 * _DAY_S  # after the end, of a clock that nobody set
_LIMIT_S = 30.0
_AUTHORITY = "authority.crt"
_CERTIFICATE = "host.crt"
_KEY = "host.key"
_NAMES = "names.txt"
_FILES = (_AUTHORITY, _CERTIFICATE, _KEY, _NAMES)
_UNSURE = "clock_not_set"  # exists until a clock that was set confirms the dates

log = logging.getLogger(__name__)


class CertificateError(Exception):
    """Raised when there is no usable certificate: one line with the cause and what to do."""


class _DamagedError(CertificateError):
    """Raised when the files can be read but are no certificate and its key."""


class Certificate:
    """The certificate in `folder`/tls; created if there is none or it expires soon."""

    def __init__(
        self,
        folder: Path,
        names: Sequence[str],
        wall: Callable[[], float] = time.time,
        clock_is_right: Callable[[], bool] = is_set,
    ) -> None:
        """`names`: host names and addresses by which pages reach this host. Raises
        CertificateError."""
        self._folder = folder / "tls"
        now_s = wall()
        trusted = clock_is_right() and now_s >= EARLIEST_S
        if not self._usable() or self._over(now_s, trusted):
            try:
                _make(self._folder, names, _begin_s(now_s, trusted), trusted)
            except CertificateError as error:
                if not self._usable():
                    raise
                log.error("the certificate ends soon or has ended, and stays in use: %s", error)
            else:
                log.warning(
                    "new certificate: tablets and phones must trust the new %s", self.authority
                )
        else:
            named = (self._folder / _NAMES).read_text(errors="replace")
            missing = set(names) - set(named.split())
            if missing:
                log.warning(
                    "the certificate in %s does not name %s; remove that folder to make a new one",
                    self._folder,
                    ", ".join(sorted(missing)),
                )

    @property
    def authority(self) -> Path:
        """The file that a tablet must trust."""
        return self._folder / _AUTHORITY

    def context(self) -> ssl.SSLContext:
        """For the server's connections: TLS 1.2 or newer."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.set_alpn_protocols(["http/1.1"])
        try:
            context.load_cert_chain(self._folder / _CERTIFICATE, self._folder / _KEY)
        except ssl.SSLError as error:
            raise _DamagedError(
                f"the certificate in {self._folder} is damaged ({error}); remove that folder"
            ) from None
        except OSError as error:
            raise self._unreadable(error) from None
        return context

    def _usable(self) -> bool:
        try:
            for name in _FILES:
                (self._folder / name).read_bytes()
            self.context()
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            return False
        except OSError as error:
            raise self._unreadable(error) from None
        except _DamagedError as error:
            log.error("%s", error)
            return False
        arguments = ["verify", "-no_check_time", "-CAfile", _AUTHORITY, _CERTIFICATE]
        signed = self._ask(arguments)
        if signed is not None and signed.returncode != 0:
            log.error("%s: %s did not sign %s", self._folder, _AUTHORITY, _CERTIFICATE)
            return False
        return True

    def _unreadable(self, error: OSError) -> CertificateError:
        # No reason to replace a certificate that tablets trust.
        return CertificateError(
            f"the certificate in {self._folder} cannot be read ({error.strerror});"
            " make it readable, or remove that folder"
        )

    def _over(self, now_s: float, trusted: bool) -> bool:
        found = self._ask(["x509", "-in", _CERTIFICATE, "-noout", "-startdate", "-enddate"])
        if found is None or found.returncode != 0:
            return False
        dates = [line.partition("=")[2] for line in found.stdout.splitlines()]
        begin_s, end_s = map(ssl.cert_time_to_seconds, dates)
        unsure = self._folder / _UNSURE
        if begin_s <= now_s < end_s - _RENEW_S:
            if trusted:
                with contextlib.suppress(OSError):
                    unsure.unlink(missing_ok=True)
            return False
        # A computer that is switched on each day may start before any network sets its clock, which
        # then has its own battery. One without says long ago, or anything. Of two clocks that
        # nobody set, the earlier is believed.
        earliest_s = EARLIEST_S if unsure.exists() else begin_s
        believed = trusted or earliest_s <= now_s < end_s + _BELIEVED_S
        if not believed:
            log.warning(
                "the certificate is valid from %s to %s, by a clock that nobody set", *dates
            )
        return believed

    def _ask(self, arguments: list[str]) -> subprocess.CompletedProcess[str] | None:
        # None: no answer, which is no reason to replace a certificate that tablets trust.
        try:
            return _openssl(self._folder, arguments)
        except CertificateError as error:
            log.warning("the certificate is not checked: %s", error)
            return None


def _begin_s(now_s: float, trusted: bool) -> float:
    """When a certificate made now begins, by a clock that may be wrong in either direction.

    Of a clock that nobody set, only that the fixed dates are over is believed: they serve nobody.
    """
    over = now_s > EARLIEST_S + DAYS * _DAY_S - _RENEW_S
    if not (trusted or over):
        return EARLIEST_S
    return now_s - _DAY_S  # the tablet's clock may be late


def _make(folder: Path, names: Sequence[str], begin_s: float, trusted: bool) -> None:
    # In a separate folder that gets its final name once it is complete.
    fresh = folder.with_name("tls.new")
    try:
        for place in (fresh, folder):
            if place.is_symlink() or place.is_file():
                set_aside(place)
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir(mode=0o700, parents=True)
        (fresh / _NAMES).write_text("\n".join(names) + "\n")
        alternatives = ",".join(_alternative(name) for name in names)
        (fresh / _SIGNING).write_text(_SIGNING_TEXT.format(names=alternatives))
        (fresh / _INDEX).touch()
        for arguments in _steps(names[0], begin_s):
            done = _openssl(fresh, arguments)
            if done.returncode != 0:
                last = (done.stderr.strip().splitlines() or ["?"])[-1]
                raise CertificateError(f"openssl {arguments[0]} failed: {last}")
        for path in fresh.iterdir():
            if path.name not in _FILES:
                path.unlink()
        if not trusted:
            (fresh / _UNSURE).write_text("made by a clock that nobody had set\n")
        (fresh / _KEY).chmod(0o600)
        os.sync()  # a power cut must not leave names without content
        shutil.rmtree(folder, ignore_errors=True)
        fresh.rename(folder)
    except OSError as error:
        raise CertificateError(f"{fresh}: {error.strerror}; is it writable?") from None


# `openssl ca` is the one command of every OpenSSL that takes dates.
_SIGNING = "signing.cnf"
_INDEX = "index.txt"
_SIGNING_TEXT = f"""
[ca]
default_ca = own
[own]
database = {_INDEX}
new_certs_dir = .
rand_serial = yes
default_md = sha256
unique_subject = no
policy = own_policy
[own_policy]
commonName = supplied
[authority]
basicConstraints = critical,CA:TRUE,pathlen:0
keyUsage = critical,keyCertSign
subjectKeyIdentifier = hash
[host]
basicConstraints = critical,CA:FALSE
keyUsage = critical,digitalSignature
extendedKeyUsage = serverAuth
subjectKeyIdentifier = hash
authorityKeyIdentifier = keyid
subjectAltName = {{names}}
"""


def _steps(name: str, begin_s: float) -> list[list[str]]:
    request = ["req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    request += ["-nodes", "-sha256"]
    begin, end = (_date(at_s) for at_s in (begin_s, begin_s + DAYS * _DAY_S))
    sign = ["ca", "-batch", "-notext", "-config", _SIGNING, "-keyfile", "authority.key"]
    sign += ["-startdate", begin, "-enddate", end]
    return [
        [
            *(*request, "-subj", f"/CN=gazechair on {name[:40]}"),
            *("-keyout", "authority.key", "-out", "authority.csr"),
        ],
        [*request, "-subj", f"/CN={name[:60]}", "-keyout", _KEY, "-out", "host.csr"],
        [
            *(*sign, "-selfsign", "-extensions", "authority"),
            *("-in", "authority.csr", "-out", _AUTHORITY),
        ],
        [
            *(*sign, "-cert", _AUTHORITY, "-extensions", "host"),
            *("-in", "host.csr", "-out", _CERTIFICATE),
        ],
    ]


def _date(at_s: float) -> str:
    return time.strftime("%Y%m%d%H%M%SZ", time.gmtime(at_s))


def _alternative(name: str) -> str:
    try:
        return f"IP:{ipaddress.ip_address(name)}"
    except ValueError:
        return f"DNS:{name}"


def _openssl(folder: Path, arguments: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            ["openssl", *arguments],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
    except OSError:
        raise CertificateError(
            "encryption needs the command openssl; install it (apt install openssl)"
        ) from None
    except subprocess.TimeoutExpired:
        raise CertificateError(
            f"openssl {arguments[0]} did not end within {_LIMIT_S:.0f} s"
        ) from None
