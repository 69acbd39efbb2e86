"""What every test shares: Hypothesis that draws the same examples each time and does not time them."""

from hypothesis import HealthCheck, settings

# A first call compiles for seconds, and a busy machine is slow: neither is an error.
settings.register_profile("softbody", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("softbody")
