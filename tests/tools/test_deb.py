"""The Debian package, installed into clean root file systems without a network."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import resource
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from fulldisk import full
from gazechair.board import ports
from gazechair.service import hotspot
from gazedeb import __main__, package
from gazedeb.udev import rules
from gazesetup import NotAvailable
from gazesetup.apt import debian_archives

FILES = Path(package.__file__).parent / "files"
SUITES = ("bookworm", "trixie")
STEP_S = 300.0
INSTALLED_S = 120.0  # of processor time: however busy the machine is otherwise
PAGE = """
import ssl, time, urllib.request
anyone = ssl._create_unverified_context()
for attempt in range(200):
    try:
        print(urllib.request.urlopen("https://127.0.0.1:8080/pair", context=anyone).status)
        break
    except OSError:
        time.sleep(0.1)
"""


@pytest.mark.parametrize("name", ["postinst", "prerm", "postrm", "gazechair", "gazechair-version"])
def test_each_script_is_sound_shell(name: str) -> None:
    subprocess.run(["sh", "-n", str(FILES / name)], check=True)


def test_the_service_is_confined() -> None:
    words = ["systemd-analyze", "security", "--offline=true", "--threshold=30"]
    done = subprocess.run([*words, str(FILES / "gazechair.service")], capture_output=True)
    assert done.returncode == 0, done.stdout.decode()[-200:]


def test_udev_knows_every_device_of_the_hosts_table() -> None:
    text = rules()
    for vendor, product, role, _what in ports.KNOWN:
        named = f'ATTRS{{idVendor}}=="{vendor:04x}"'
        if product is not None:
            named += f', ATTRS{{idProduct}}=="{product:04x}"'
        assert (named in text) == (role != ports.OTHER)


def test_a_port_is_the_groups_that_the_service_and_the_advice_have() -> None:
    """GROUP replaces Debian's: another one would make the advice useless."""
    groups = set(re.findall('GROUP="([^"]*)"', rules()))
    joined = re.search("for group in (.*); do", (FILES / "postinst").read_text())
    assert joined is not None
    assert len(groups) == 1
    assert groups <= {*joined[1].split()}
    assert groups <= {*ports.PERMIT.split()}


def test_the_serial_number_in_a_devices_name_is_found_before(tmp_path: Path) -> None:
    assert "$env{ID_SERIAL_SHORT}" in rules()
    package._lay_out(tmp_path, "1.0")
    (file,) = (tmp_path / "usr/lib/udev/rules.d").iterdir()
    assert file.read_text() == rules()
    assert "60-serial.rules" < file.name < "77-mm", "udev reads its files in this order"


def test_uncommitted_changes_are_another_version_that_debian_sorts_between(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The installer keeps the environment of a version that it has made."""
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "somebody")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "somebody@localhost")

    def git(*words: str) -> None:
        subprocess.run(["git", "-C", str(tmp_path), *words], check=True, capture_output=True)

    found = []
    git("init")
    for number in range(2):
        git("commit", "--allow-empty", "--message", "something")
        found.append(package.version_of(tmp_path))
        (tmp_path / f"{number}.py").touch()
        found.append(package.version_of(tmp_path))
        git("add", ".")
    for older, newer in itertools.pairwise(found):
        words = ["dpkg", "--compare-versions", older, "lt", newer]
        assert subprocess.run(words).returncode == 0, words


def test_each_package_is_locked_by_the_hash_of_its_file(tmp_path: Path) -> None:
    (tmp_path / "some_thing-1.0-py3-none-any.whl").write_bytes(b"one")
    (tmp_path / "other-2.0-cp311-cp311-a.whl").write_bytes(b"two")
    (tmp_path / "other-2.0-cp313-cp313-a.whl").write_bytes(b"three")
    other, thing = package._hashed(tmp_path).splitlines()
    assert other.startswith("other==2.0 --hash=sha256:")
    assert other.count("--hash") == 2
    assert thing.startswith("some_thing==1.0 --hash=sha256:7692c3ad3540bb803c020b3aee66cd88")


def test_the_services_user_may_read_what_was_packed_under_a_strict_umask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(_version: str, folder: Path) -> Path:
        package._lay_out(folder, "1.0")
        return folder

    monkeypatch.setattr(__main__, "build", build)
    monkeypatch.setattr(__main__, "ROOT", tmp_path)
    monkeypatch.setattr(__main__, "version_of", lambda _: "1.0")
    before = os.umask(0o077)
    try:
        assert __main__.main() == 0
    finally:
        os.umask(before)
    made = [*(tmp_path / "build").rglob("*")]
    assert made
    assert {path for path in made if path.stat().st_mode & 0o044 != 0o044} == set()


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the wheels are kept."""
    monkeypatch.setattr(package, "LOCAL", tmp_path)
    return tmp_path / "deb"


def fetch(words: tuple[str, ...]) -> None:
    """As pip puts a wheel into the named folder."""
    option = "--wheel-dir" if words[0] == "wheel" else "--dest"
    folder = Path(words[words.index(option) + 1])
    folder.mkdir(exist_ok=True)
    (folder / f"{len([*folder.iterdir()])}.whl").touch()


def test_two_builds_at_once_fetch_the_wheels_once(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[Path] = []
    both = [threading.Thread(target=lambda: done.append(package._wheels())) for _ in range(2)]
    calls: list[str] = []

    def pip(*words: str) -> None:
        calls.append(words[0])
        if len(calls) == 1:
            both[1].start()
            time.sleep(0.2)  # for the other to meddle
        fetch(words)

    monkeypatch.setattr(package, "_pip", pip)
    both[0].start()
    for one in both:
        one.join(20.0)
    assert calls == ["wheel", *["download"] * len(package.PYTHONS)]
    assert [len([*path.iterdir()]) for path in done] == [len(calls)] * 2
    assert [*cache.iterdir()] == done[:1]


def test_half_of_the_wheels_is_not_kept(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(package, "_pip", lambda *words: fetch(words))
    for does in ("copyfile", "rename"):
        with monkeypatch.context() as context:
            context.setattr(shutil if does == "copyfile" else Path, does, full)
            with contextlib.suppress(OSError, NotAvailable):
                package._wheels()
        assert len([*package._wheels().iterdir()]) == 1 + len(package.PYTHONS)
        shutil.rmtree(cache)


class Root:
    """A clean root file system of one Debian suite; what runs in it has no network."""

    def __init__(self, folder: Path, suite: str) -> None:
        self.folder = folder
        needed = "python3,python3-venv,openssl"
        words = ["mmdebstrap", "--quiet", "--variant=minbase", f"--include={needed}"]
        subprocess.run(
            [*words, suite, str(folder), debian_archives()[0].uri], check=True, timeout=STEP_S
        )
        for name in ("proc", "dev"):
            subprocess.run(["mount", "--rbind", f"/{name}", str(folder / name)], check=True)

    def command(self, *words: str) -> list[str]:
        script = 'ip link set lo up; exec chroot "$@"'
        return ["unshare", "--net", "sh", "-c", script, "sh", str(self.folder), *words]

    def run(self, *words: str) -> str:
        return _run(self.command(*words))

    def page(self, service: int) -> str:
        """What the first page answers, in the network of the service with that process id."""
        python = "/opt/gazechair/current/bin/python"
        there = ["nsenter", f"--net=/proc/{service}/ns/net", "chroot", str(self.folder)]
        return _run([*there, python, "-c", PAGE])

    def install(self, deb: Path) -> None:
        shutil.copy(deb, self.folder / "tmp")
        self.run("dpkg", "--install", f"/tmp/{deb.name}")

    def close(self) -> None:
        for name in ("dev", "proc"):
            subprocess.run(["umount", "--recursive", "--lazy", str(self.folder / name)])


def _run(words: list[str]) -> str:
    env = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8"}
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=STEP_S)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def used_s() -> float:
    """Processor time of every child that has ended, seconds."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.fixture(scope="module")
def debs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The package as two versions."""
    folder = tmp_path_factory.mktemp("debs")
    try:
        return [package.build(version, folder) for version in ("1.0+1.aaa", "1.0+2.bbb")]
    except NotAvailable as error:
        pytest.skip(str(error))


@pytest.fixture(params=SUITES)
def root(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Root]:
    if os.geteuid() != 0 or shutil.which("mmdebstrap") is None:
        pytest.skip("needs root and Debian's mmdebstrap")
    made = Root(tmp_path / "root", request.param)
    yield made
    made.close()


@contextlib.contextmanager
def running(root: Root) -> Iterator[socket.socket]:
    """The service as its unit runs it, once its page answers; and what it tells systemd next."""
    received = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    place = root.folder / "run" / "notify"
    received.bind(str(place))
    place.chmod(0o777)
    received.settimeout(60.0)
    environment_lines = ["NOTIFY_SOCKET=/run/notify", "WATCHDOG_USEC=1000000"]
    environment_lines.append("STATE_DIRECTORY=/var/lib/gazechair")
    command = ["/opt/gazechair/current/bin/gazechair", "run"]
    command += ["--config", "/etc/gazechair/gazechair.toml"]
    words = ["runuser", "-u", "gazechair", "--", "env", *environment_lines, *command]
    service = subprocess.Popen(root.command(*words), stdout=subprocess.DEVNULL)
    try:
        assert received.recv(1000).startswith(b"READY=1")
        assert root.page(service.pid) == "200\n"
        yield received
    finally:
        service.terminate()
        service.wait(20)
        received.close()
        place.unlink()


@pytest.mark.long
def test_it_installs_offline_serves_is_upgraded_and_goes_back(root: Root, debs: list[Path]) -> None:
    older, newer = debs
    start_s, used_before_s = time.monotonic(), used_s()
    root.install(older)
    with running(root) as received:
        took_s = time.monotonic() - start_s
        assert received.recv(1000) == b"WATCHDOG=1"
        assert "caretaker" in root.run("gazechair", "pair", "--role", "caretaker")
        # No board is plugged in: it ends with 1.
        found = root.run("sh", "-c", "gazechair doctor || [ $? = 1 ]")
        assert "configuration: /etc/gazechair/gazechair.toml" in found
    took_cpu_s = used_s() - used_before_s  # the service's and the two commands', too
    print(f"installed and serving after {took_s:.1f} s, {took_cpu_s:.1f} s of processor time")
    assert took_cpu_s < INSTALLED_S

    config = root.folder / "etc/gazechair/gazechair.toml"
    config.write_text(config.read_text().replace('#language = "nl"', 'language = "en"'))
    state = root.folder / "var/lib/gazechair"
    kept = {path: path.read_bytes() for path in state.rglob("*") if path.is_file()}
    assert state / "tls" / "host.key" in kept

    root.install(newer)
    assert root.run("gazechair-version").splitlines() == ["runs: 1.0+2.bbb", "before: 1.0+1.aaa"]
    assert 'language = "en"' in config.read_text()
    with running(root):
        pass
    root.run("gazechair-version", "back")
    assert root.run("gazechair-version").splitlines() == ["runs: 1.0+1.aaa", "before: 1.0+2.bbb"]
    with running(root):
        pass
    assert {path: path.read_bytes() for path in kept} == kept

    wifi = hotspot._file(root.folder / hotspot.FOLDER.relative_to("/"))
    wifi.parent.mkdir(parents=True, exist_ok=True)
    wifi.write_text(hotspot.keyfile("gazechair", "password", ""))
    root.run("dpkg", "--purge", "gazechair")
    assert not wifi.exists()
    assert not (root.folder / "opt/gazechair").exists()
    assert not config.exists()
