"""A second start in the folder of a run: refused while the first one goes on, and afterwards unless told."""

import signal

import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io import FolderLock
from tests.support.same_runs import assert_same_runs, copy, run_with_signal


@pytest.mark.parametrize("how", [{"resume": True}, {"overwrite": True}, {"overwrite": False}])
def test_two_at_once(scene, whole, tmp_path, how):
    """The second one is refused before it touches anything, and the first one goes on."""
    refusals = []

    def start_another(report):
        if not refusals:
            before = {path.name: path.stat().st_size for path in tmp_path.iterdir() if path.suffix != ".vtkhdf"}
            with pytest.raises(InputError, match="another program is running there") as refusal:
                snowmpm.run(scene, tmp_path, **how)
            refusals.append(refusal)
            assert before.keys() <= {path.name for path in tmp_path.iterdir()}

    snowmpm.run(scene, tmp_path, start_another)
    assert refusals
    assert_same_runs(whole, tmp_path)


def test_two_that_start_at_once(scene, tmp_path, monkeypatch):
    """Neither folder nor run was there when the second one looked; the first has meanwhile begun, or even ended."""
    folder, build = tmp_path / "run", snowmpm.running.loop.Simulation
    going = FolderLock(folder)

    def late(*arguments, **options):
        going.make()
        return build(*arguments, **options)

    monkeypatch.setattr(snowmpm.running.loop, "Simulation", late)
    with pytest.raises(InputError, match="another program is running there"):
        snowmpm.run(scene, folder)
    assert not any(folder.iterdir())
    (folder / "run.vtkhdf").write_bytes(b"of the first")
    monkeypatch.setattr(going, "make", lambda: None)
    going.__exit__()
    with pytest.raises(InputError, match=r"already holds a run|was not written by"):
        snowmpm.run(scene, folder, overwrite=False)
    assert (folder / "run.vtkhdf").read_bytes() == b"of the first"


def test_the_folder_is_free_after_a_run_that_was_interrupted(scene, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene, tmp_path, signal.SIGINT, 0.0)
    with FolderLock(tmp_path):
        pass


def test_killed_before_the_first_checkpoint(scene, whole, stopped, tmp_path):
    """Nothing is lost when a run with the first frame at most begins anew; with more of them it is refused."""
    folder = copy(stopped, tmp_path)
    for path in folder.glob("checkpoint*"):
        path.unlink()
    with pytest.raises(InputError, match="no checkpoint to resume from"):
        snowmpm.run(scene, folder, resume=True)
    with snowmpm.io.RunWriter.reopen(folder, until=0.0):
        pass
    with snowmpm.io.RunWriter.reopen(folder) as writer:
        writer.close(complete=False)
    snowmpm.run(scene, folder, resume=True)
    assert_same_runs(whole, folder)
