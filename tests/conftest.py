"""What every test shares: Hypothesis that draws the same examples each time and does not time them."""

from hypothesis import settings

settings.register_profile("softbody", deadline=None, derandomize=True)  # a first call compiles for seconds
settings.load_profile("softbody")
