"""Do the errors carry what the caller needs, also from one process to another?"""

import pickle

from softbody import SimulationError


def test_a_simulation_error_survives_pickling():
    error = pickle.loads(pickle.dumps(SimulationError("it fell apart", 7, "soft body 2", 0.25)))
    assert (str(error), error.step, error.body, error.stable_time_step) == ("it fell apart", 7, "soft body 2", 0.25)
