"""The package's scripts with stand-ins for what they call: environments, and what a purge ends."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gazechair.service import hotspot
from gazedeb import package

FILES = Path(package.__file__).parent / "files"
STAND_INS = {
    "getent": "true",
    "useradd": "true",
    "usermod": "true",
    "install": 'for last; do :; done; mkdir -p "$last"',
    "sync": "true",
    "chgrp": "true",
    "systemctl": "true",
    "udevadm": "true",
    "nmcli": "exit 8",  # NetworkManager does not run
    "touch": '/bin/touch "$1"',
    "python3": 'mkdir -p "$3/bin"; for name in python gazechair; do\n'
    'printf "#!/bin/sh\\n" >"$3/bin/$name"; chmod +x "$3/bin/$name"; done',
}


class Machine:
    """A folder as the root of a file system, with the scripts of one version."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._called = folder / "called"
        self._env = {**os.environ, "PATH": f"{folder}/stand-ins:/usr/bin:/bin"}
        self.version = folder / "opt/gazechair/1.0"
        stand_ins = folder / "stand-ins"
        stand_ins.mkdir()
        for name, act in STAND_INS.items():
            path = stand_ins / name
            path.write_text(f'#!/bin/sh\necho "{name} $*" >>"{self._called}"\n{act}\n')
            path.chmod(0o755)
        for name, place in (
            ("postinst", "postinst"),
            ("prerm", "prerm"),
            ("postrm", "postrm"),
            ("gazechair-version", "usr/sbin"),
        ):
            text = (FILES / name).read_text().replace("@VERSION@", self.version.name)
            for top in ("/opt/", "/var/lib/", "/usr/sbin/gaze", "/run/systemd", "/etc/"):
                text = text.replace(top, f"{folder}{top}")
            path = folder / place
            if place != name:
                path.mkdir(parents=True)
                path /= name
            path.write_text(text)
            path.chmod(0o755)

    def upgrade(self, name: str) -> None:
        """Install version `name` after this one."""
        postinst = self._folder / "postinst"
        postinst.write_text(postinst.read_text().replace(self.version.name, name))
        self.version = self.version.with_name(name)
        self.install()

    def change(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Run gazechair-version with these words."""
        command = [self._folder / "usr/sbin/gazechair-version", *words]
        return subprocess.run(command, capture_output=True, text=True, env=self._env)

    def with_systemd(self) -> None:
        """Run as a service from now on."""
        (self._folder / "run/systemd/system").mkdir(parents=True)

    def restarts(self) -> int:
        """How often the service was restarted since the last installation began."""
        return self._called.read_text().count("systemctl restart gazechair.service")

    def remove(self, *steps: tuple[str, str]) -> str:
        """Run scripts of a removal, each with its word; what they print."""
        self._called.write_text("")
        return "".join(
            subprocess.run(
                [self._folder / name, word],
                env=self._env,
                check=True,
                stdout=subprocess.PIPE,
                text=True,
            ).stdout
            for name, word in steps
        )

    def called(self) -> list[str]:
        """The stand-ins that the last script called, with their words."""
        return self._called.read_text().splitlines()

    def install(self) -> list[str]:
        """Run the installer; the stand-ins that it called, with their words."""
        self._called.write_text("")
        env = {**self._env, "DPKG_MAINTSCRIPT_NAME": "postinst"}
        subprocess.run([self._folder / "postinst", "configure"], env=env, check=True)
        return self.called()


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_an_environment_is_on_the_disk_before_it_counts_as_complete(machine: Machine) -> None:
    called = machine.install()
    home = machine.version.parent
    assert called[-2:] == [f"sync -f {home}", f"touch {machine.version}/complete"]
    assert (home / "current").resolve() == machine.version


def test_the_services_user_may_run_what_was_installed_under_a_strict_umask(
    machine: Machine,
) -> None:
    before = os.umask(0o077)
    try:
        machine.install()
    finally:
        os.umask(before)
    made = [machine.version.parent, machine.version, *machine.version.rglob("*")]
    assert {path for path in made if path.stat().st_mode & 0o044 != 0o044} == set()


def test_a_complete_environment_is_not_made_again(machine: Machine) -> None:
    machine.install()
    assert f"python3 -m venv {machine.version}" not in machine.install()


def test_an_environment_of_a_python_that_is_gone_is_made_again(machine: Machine) -> None:
    machine.install()
    program = machine.version / "bin/gazechair"
    program.write_text("#!/bin/sh\necho 'No module named gazechair' >&2\nexit 1\n")
    assert f"python3 -m venv {machine.version}" in machine.install()
    assert subprocess.run([program, "--version"]).returncode == 0
    assert (machine.version / "complete").exists()


def test_the_version_before_runs_again(machine: Machine) -> None:
    machine.install()
    first = machine.version
    machine.upgrade("2.0")
    assert machine.change("back").returncode == 0
    assert (first.parent / "current").resolve() == first


def test_a_change_that_a_power_cut_interrupted_is_told_with_the_versions_there_are(
    machine: Machine,
) -> None:
    machine.install()
    home = machine.version.parent
    machine.upgrade("2.0")
    before = home / "before"
    before.unlink()
    before.symlink_to("2.0")  # the first of the two links that `back` replaces
    output = machine.change("back")
    assert output.stdout.splitlines() == [
        "gazechair runs version 2.0 already; there are:",
        "1.0",
        "2.0",
    ]
    assert machine.change("use", "1.0").stdout == "gazechair runs version 1.0 now\n"
    assert (home / "current").resolve() == home / "1.0"


@pytest.mark.parametrize("words", [("back",), ("use", "1.0")])
def test_the_service_restarts_with_the_version_that_is_told(
    machine: Machine, words: tuple[str, ...]
) -> None:
    machine.with_systemd()
    machine.install()
    machine.upgrade("2.0")
    assert machine.restarts() == 1  # at the installer's end, when systemd knows the new unit
    output = machine.change(*words)
    assert output.stdout == "gazechair runs version 1.0 now\n"
    assert machine.restarts() == 2


@pytest.mark.parametrize(
    "name", ["current", "before", "3.0", "current/", "before/", "1.0/", "2.0/.", "", "."]
)
def test_what_is_no_version_is_refused(machine: Machine, name: str) -> None:
    machine.install()
    machine.upgrade("2.0")
    before = {path.name: path.resolve() for path in machine.version.parent.iterdir()}
    assert machine.change("use", name).returncode == 2
    assert {path.name: path.resolve() for path in machine.version.parent.iterdir()} == before


def test_a_version_before_that_does_not_start_is_refused(machine: Machine) -> None:
    machine.install()
    first = machine.version
    machine.upgrade("2.0")
    (first / "bin/gazechair").write_text("#!/bin/sh\nexit 1\n")
    ended = machine.change("back")
    assert ended.returncode == 2
    assert "version 1.0" in ended.stderr
    assert "does not start" in ended.stderr
    assert (first.parent / "current").resolve() == machine.version


def configured(machine: Machine, content: str) -> Path:
    """The machine's configuration, which the version in use has accepted."""
    file = machine.version.parents[2] / "etc/gazechair/gazechair.toml"
    file.parent.mkdir(parents=True)
    file.write_text(content)
    return file


def with_hosts_python(version: Path) -> None:
    """Has `version` read configurations as this host does."""
    path = os.pathsep.join(sys.path)
    (version / "bin/python").write_text(
        f'#!/bin/sh\n[ "$1" = -I ] && shift\nPYTHONPATH={path} exec {sys.executable} "$@"\n'
    )


@pytest.mark.parametrize("words", [("back",), ("use", "1.0")])
def test_a_version_that_refuses_the_configuration_is_refused_with_the_line(
    machine: Machine, words: tuple[str, ...]
) -> None:
    machine.install()
    with_hosts_python(machine.version)
    machine.upgrade("2.0")
    file = configured(machine, '[web]\nhost = "0.0.0.0"\nof_2_0 = true\n')
    ended = machine.change(*words)
    assert ended.returncode == 2
    assert "version 1.0 refuses the configuration; 2.0 stays\n" in ended.stderr
    assert f"{file}:3: web.of_2_0 is no setting" in ended.stderr
    assert machine.version.with_name("current").resolve() == machine.version
    file.write_text(file.read_text().replace("of_2_0", "#of_2_0"))
    assert machine.change(*words).returncode == 0


def test_a_version_before_accepts_the_packages_own_configuration(machine: Machine) -> None:
    """Also that of a later package: it sets nothing that a version could lack."""
    machine.install()
    with_hosts_python(machine.version)
    machine.upgrade("2.0")
    newer = package._configuration() + "# a new table\n[newer]\n# a new setting\n#of_2_0 = true\n"
    configured(machine, newer)
    assert machine.change("back").returncode == 0


def test_an_upgrade_that_refuses_the_configuration_keeps_the_version_that_runs(
    machine: Machine,
) -> None:
    machine.install()
    first = machine.version
    newer = shutil.copytree(first, first.with_name("2.0"))
    with_hosts_python(newer)
    configured(machine, "[of_1_0]\nx = 1\n")
    with pytest.raises(subprocess.CalledProcessError):
        machine.upgrade("2.0")
    assert first.with_name("current").resolve() == first


REMOVE = (("prerm", "remove"), ("postrm", "remove"))
PURGE = ("postrm", "purge")
END_WIFI = "nmcli connection delete id gazechair"


def hotspot_on(folder: Path) -> Path:
    """The file that `gazechair hotspot on` leaves."""
    file = hotspot._file(folder / hotspot.FOLDER.relative_to("/"))
    file.parent.mkdir(parents=True)
    file.write_text(hotspot.keyfile("gazechair", "password", ""))
    return file


def test_a_purge_ends_the_chairs_wifi(machine: Machine, tmp_path: Path) -> None:
    wifi = hotspot_on(tmp_path)
    other = wifi.with_name("home.nmconnection")
    other.touch()
    machine.remove(*REMOVE, PURGE)
    assert machine.called() == [END_WIFI]
    assert not wifi.exists()
    assert other.exists()


def test_a_purge_ends_no_network_of_that_name_that_is_not_the_chairs(machine: Machine) -> None:
    machine.remove(*REMOVE, PURGE)
    assert machine.called() == []


def test_a_removal_keeps_the_chairs_wifi_and_says_what_ends_it(
    machine: Machine, tmp_path: Path
) -> None:
    assert machine.remove(*REMOVE) == ""
    wifi = hotspot_on(tmp_path)
    assert END_WIFI in machine.remove(*REMOVE)
    assert machine.remove(("prerm", "upgrade"), ("postrm", "upgrade")) == ""
    assert wifi.exists()
    assert machine.called() == []
