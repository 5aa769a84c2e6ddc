"""The host's own certificate, created once with the `openssl` command.

It is kept in the state folder. A local authority signs it, and the authority's key is then deleted:
a tablet that trusts this authority trusts this one certificate, and nobody can ever make another.
Both are valid for 820 days, the longest that iOS accepts.
"""

from __future__ import annotations

import ipaddress
import logging
import os
import shutil
import ssl
import subprocess
from collections.abc import Sequence
from pathlib import Path

DAYS = 820
_RENEW_S = 14 * 86_400
_LIMIT_S = 30.0
_AUTHORITY = "authority.crt"
_CERTIFICATE = "host.crt"
_KEY = "host.key"
_NAMES = "names.txt"

log = logging.getLogger(__name__)


class CertificateError(Exception):
    """Raised when no certificate can be made: one line with the cause and what to do."""


class Certificate:
    """The certificate in `folder`/tls; created if there is none or it expires soon."""

    def __init__(self, folder: Path, names: Sequence[str]) -> None:
        """`names`: host names and addresses by which pages reach this host. Raises
        CertificateError."""
        self._folder = folder / "tls"
        if not self._usable():
            _make(self._folder, names)
            log.warning("new certificate: tablets and phones must trust the new %s", self.authority)
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
        except (OSError, ssl.SSLError) as error:
            raise CertificateError(
                f"the certificate in {self._folder} is damaged ({error}); remove that folder"
            ) from None
        return context

    def _usable(self) -> bool:
        files = (_AUTHORITY, _CERTIFICATE, _KEY, _NAMES)
        if not all((self._folder / name).is_file() for name in files):
            return False
        try:
            self.context()
        except CertificateError as error:
            log.error("%s", error)
            return False
        path = str(self._folder / _CERTIFICATE)
        return _openssl(["x509", "-in", path, "-noout", "-checkend", str(_RENEW_S)]) is None


def _make(folder: Path, names: Sequence[str]) -> None:
    # In a separate folder that gets its final name once it is complete.
    fresh = folder.with_name("tls.new")
    shutil.rmtree(fresh, ignore_errors=True)
    try:
        fresh.mkdir(mode=0o700, parents=True)
        (fresh / _NAMES).write_text("\n".join(names) + "\n")
        (fresh / "extensions.txt").write_text(
            "basicConstraints=critical,CA:FALSE\n"
            "keyUsage=critical,digitalSignature\n"
            "extendedKeyUsage=serverAuth\n"
            f"subjectAltName={','.join(_alternative(name) for name in names)}\n"
        )
        for words in _steps(fresh, names[0]):
            failure = _openssl(words)
            if failure is not None:
                raise CertificateError(failure)
        for name in ("authority.key", "authority.srl", "host.csr", "extensions.txt"):
            (fresh / name).unlink(missing_ok=True)
        (fresh / _KEY).chmod(0o600)
        os.sync()  # a power cut must not leave names without content
        shutil.rmtree(folder, ignore_errors=True)
        fresh.rename(folder)
    except OSError as error:
        raise CertificateError(f"{fresh}: {error.strerror}; is it writable?") from None


def _steps(at: Path, name: str) -> list[list[str]]:
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-sha256"]
    days = ["-days", str(DAYS)]
    authority = ["-subj", f"/CN=gazechair on {name[:40]}", *days]
    authority += ["-addext", "basicConstraints=critical,CA:TRUE,pathlen:0"]
    authority += ["-addext", "keyUsage=critical,keyCertSign"]
    keys = ["-keyout", str(at / "authority.key"), "-out", str(at / _AUTHORITY)]
    request = ["-keyout", str(at / _KEY), "-out", str(at / "host.csr"), "-subj", f"/CN={name[:60]}"]
    sign = ["-in", str(at / "host.csr"), "-out", str(at / _CERTIFICATE), *days, "-sha256"]
    sign += ["-CA", str(at / _AUTHORITY), "-CAkey", str(at / "authority.key"), "-CAcreateserial"]
    sign += ["-extfile", str(at / "extensions.txt")]
    return [
        ["req", "-x509", *curve, *authority, *keys],
        ["req", "-new", *curve, *request],
        ["x509", "-req", *sign],
    ]


def _alternative(name: str) -> str:
    try:
        return f"IP:{ipaddress.ip_address(name)}"
    except ValueError:
        return f"DNS:{name}"


def _openssl(words: list[str]) -> str | None:
    # None on success, else one line.
    try:
        done = subprocess.run(
            ["openssl", *words], capture_output=True, text=True, timeout=_LIMIT_S, check=False
        )
    except FileNotFoundError:
        return "encryption needs the command openssl; install it (apt install openssl)"
    except subprocess.TimeoutExpired:
        return f"openssl {words[0]} did not end within {_LIMIT_S:.0f} s"
    if done.returncode == 0:
        return None
    return f"openssl {words[0]} failed: {(done.stderr.strip().splitlines() or ['?'])[-1]}"
