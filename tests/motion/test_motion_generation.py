"""How many attempts are made, and by how many processes."""

import pytest

from sim1.motion.generation import processes_for, quotas_of
from sim1.motion.stage import CandidateTrajectoriesConfig


@pytest.mark.parametrize(
    ("ran", "successes", "more"), [(0, 0, True), (2, 2, True), (3, 1, False), (3, 0, True), (5, 0, True), (6, 0, False)]
)
def test_attempts_go_on_until_enough_ran_and_enough_succeeded(ran, successes, more):
    config = CandidateTrajectoriesConfig(candidate_count=3, success_target=1, run_limit=6, tries_per_candidate=4)
    group = [{"ran": True, "success": index < successes} for index in range(ran)]
    assert quotas_of(config, "towel")[0].wants_more(group) is more


def test_a_garment_that_is_quick_to_simulate_may_have_more_attempts_than_the_others():
    config = CandidateTrajectoriesConfig(candidate_count=3, more_of={"towel": 4}, success_target=0, run_limit=3)
    ran = [{"ran": True, "success": True}]
    assert quotas_of(config, "towel")[0].wants_more(6 * ran)
    assert not quotas_of(config, "towel")[0].wants_more(7 * ran)
    assert not quotas_of(config, "tshirt")[0].wants_more(3 * ran)
    with pytest.raises(ValueError, match="greater than or equal to 1"):
        CandidateTrajectoriesConfig(more_of={"towel": 0})


@pytest.mark.parametrize(
    ("attempts", "cores", "processes"), [(3, 16, 1), (15, 16, 1), (84, 2, 2), (84, 16, 10), (360, 16, 16), (360, 1, 1)]
)
def test_many_attempts_are_made_by_all_cores_and_a_few_by_one_process(attempts, cores, processes):
    assert processes_for(attempts, cores) == processes


def test_draws_out_of_reach_come_to_an_end():
    config = CandidateTrajectoriesConfig(candidate_count=2, run_limit=2, perturbed_count=1, tries_per_candidate=3)
    out_of_reach = [{"ran": False, "success": False}]
    meant, perturbed = quotas_of(config, "towel")
    assert meant.wants_more(5 * out_of_reach)
    assert not meant.wants_more(6 * out_of_reach)
    assert not perturbed.wants_more(3 * out_of_reach)
