"""What every test shares: Hypothesis that draws the same examples each time, and Ctrl-C that is heard."""

import signal

from hypothesis import HealthCheck, settings

# A first call compiles for seconds, and a busy machine is slow: neither is an error.
settings.register_profile("softbody", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("softbody")


def pytest_configure() -> None:
    """Hear Ctrl-C: what a script starts in the background ignores it, and so would every process it starts."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
