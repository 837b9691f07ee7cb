import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from assets_defs._doctor import print_doctor
from pipeline import Home
from sim1 import doctor, system_libraries
from sim1.doctor import Diagnosis, disk, gpu, healthy, memory, package, probe_package, python_version, versions
from sim1.progress import listening
from sim1.system_libraries import NEEDING, absent_libraries, import_error, missing_for, remedy

ROOT = Path(__file__).parents[1]
ERROR = "ImportError: libXrender.so.1: cannot open shared object file: No such file or directory"


def test_the_missing_library_is_read_from_the_import_error_and_from_ldd():
    listing = "\tlibXi.so.6 => not found\n\tlibc.so.6 => /lib/libc.so.6 (0x1)\n\tlibstdc++.so.6 => not found\n"
    assert absent_libraries(ERROR + "\n" + listing) == ["libXi.so.6", "libXrender.so.1", "libstdc++.so.6"]
    assert absent_libraries("ModuleNotFoundError: No module named 'bpy'") == []


def test_the_remedy_names_the_package_and_admits_what_it_does_not_know():
    assert remedy(["libXrender.so.1", "libSM.so.6"]) == "apt-get install libsm6 libxrender1"
    assert "libfoo.so.3" in remedy(["libfoo.so.3", "libGL.so.1"])
    assert "apt-get install libgl1" in remedy(["libfoo.so.3", "libGL.so.1"])


def test_an_import_is_tried_in_a_process_of_its_own():
    assert import_error("print(6 * 7)") == ("", "42")
    error, _ = import_error("import no_such_module_here")
    assert error == "ModuleNotFoundError: No module named 'no_such_module_here'"
    assert "9" in import_error("import os; os.kill(os.getpid(), 9)")[0]
    assert "did not answer" in import_error("import time; time.sleep(20)", limit_s=0.3)[0]


def test_on_a_working_machine_no_library_is_called_missing():
    working = [name for name in NEEDING if not import_error(f"import {name}")[0]]
    assert working  # else this says nothing
    for name in working:
        assert missing_for(name, "") == []


def test_a_package_with_a_missing_library_gets_the_package_to_install():
    found = package("bpy", "5.2.3", ERROR, ["libXrender.so.1"])
    assert (found.ok, found.required) == (False, True)
    assert "libXrender.so.1" in found.detail
    assert found.remedy == "apt-get install libxrender1"
    assert "setup" in package("bpy", "5.2.3", "ImportError: else", []).remedy
    assert package("bpy", "5.2.3", "", []) == Diagnosis(name="bpy", ok=True, detail="5.2.3")


def test_a_package_that_is_not_there_is_reported_not_raised():
    (found,) = probe_package("nothing", "no_such_module_here")
    assert not found.ok
    assert "No module named" in found.detail


def test_versions_are_compared_with_the_pins():
    text = "# pins\nNumpy==2.2.6 \\\n    --hash=sha256:aa\ntorch==2.11.0 \\\n    --hash=sha256:bb\nfoo==1 ; sys_platform == 'never'\n"
    assert versions(text, {"numpy": "2.2.6", "torch": "2.11.0"}).ok
    older = versions(text, {"numpy": "2.1.0"})
    assert not older.ok
    assert "numpy 2.1.0 (wanted 2.2.6)" in older.detail
    assert "torch missing" in older.detail
    assert not versions("", {}).ok  # a lost requirements file is no agreement


def test_python_disk_memory_and_gpu_are_judged_by_their_limits():
    assert python_version((3, 13), (3, 13)).ok
    assert not python_version((3, 12), (3, 13)).ok
    assert disk(6).ok
    assert not disk(4.9).ok
    assert memory(9, 24).ok
    assert not memory(2, 24).ok
    assert gpu("gpu", "", "NVIDIA H200").ok
    assert not gpu("gpu", "", "").ok


def test_only_what_is_required_makes_a_machine_unfit():
    assert healthy([gpu("gpu", "", ""), memory(1, 2), disk(9)])
    assert not healthy([disk(1)])


def test_the_whole_examination_covers_every_probe_in_order_and_is_json(monkeypatch):
    monkeypatch.setattr(doctor, "import_error", lambda code, **_: ("", "banner of a library\nGPU: "))
    steps = []
    with listening(lambda done, total, what: steps.append((done, total, what))):
        found = doctor.examine(ROOT)
    count = len(doctor.IMPORTS) + 4
    assert steps[0] == (0, count, "python, versions")  # said before the first has ended
    assert steps[-1] == (count, count, "")
    assert all(any(name in what.split(", ") for _, _, what in steps) for name in doctor.IMPORTS)
    names = [diagnosis.name for diagnosis in found]
    assert names[:4] == ["python", "versions", "disk", "memory"]
    assert set(doctor.IMPORTS) <= set(names)
    assert [d.ok for d in found if d.name.startswith("gpu")] == [False]  # a banner is no GPU
    assert all(d.remedy for d in found if not d.ok)
    assert json.loads(json.dumps([diagnosis.as_json() for diagnosis in found]))[0]["name"] == "python"


def test_the_command_shows_each_step_beside_its_answer_and_none_with_json(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "import_error", lambda code, **_: ("", "GPU: "))
    print_doctor(Home(ROOT), as_json=False)
    table, steps = capsys.readouterr()
    assert "works" in table
    assert "now python, versions" in steps
    assert "torch" in steps
    print_doctor(Home(ROOT), as_json=True)
    answer, steps = capsys.readouterr()
    assert json.loads(answer)["schema"] == "sim1.doctor/1"
    assert steps == ""


def test_modules_of_the_set_up_are_light():
    code = "import sys, sim1.doctor, sim1.system_libraries; print([m for m in sys.modules if m in ('numpy', 'torch', 'bpy')])"
    assert import_error(code) == ("", "[]")


@pytest.mark.parametrize("library", ["libXrender.so.1", "libunheard.so.7"])
def test_the_set_up_script_explains_a_missing_library_and_fails(tmp_path, library):
    (tmp_path / "bpy.py").write_text(
        f"raise ImportError('{library}: cannot open shared object file: No such file or directory')\n"
    )
    (tmp_path / "pymeshlab.py").write_text("")
    done = subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "system_libraries.py")],
        capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
    )  # fmt: skip
    assert done.returncode == 1
    assert library in done.stdout
    assert system_libraries.PACKAGES.get(library, "apt-file search") in done.stdout


def test_the_set_up_script_is_silent_when_all_is_well(tmp_path):
    for name in NEEDING:
        (tmp_path / f"{name}.py").write_text("")
    done = subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "system_libraries.py")],
        capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "")
