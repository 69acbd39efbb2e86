# Two commands do everything, set-up included: `make report` and `make test`.

PYTHON ?= python3
UV_VERSION := 0.13.8
UV := $(shell command -v uv 2>/dev/null || echo .uv/bin/uv)
RUN := .venv/bin/python

MINUTES ?= 2

.PHONY: report test league docs bench faults mutants fuzz matrix release-check wheel lint lock upgrade clean

report: .venv/ready  ## judge every claim, time the step, make build/report/index.html
	$(RUN) -m validation --require-all $(ARGS)

test: .venv/ready  ## run the project's own tests
	$(RUN) -m tests $(ARGS)

league: .venv/ready  ## put every engine beside every other, how right it is and what that costs: build/league/index.html
	$(RUN) -m validation.league $(ARGS)

docs: .venv/ready  ## run the examples and the claims' declarations into pages: build/docs/index.html
	$(RUN) -m sphinx -E -W --keep-going $(ARGS) docs build/docs

bench: .venv/ready  ## time the pieces beside their peers, and keep the figures
	$(RUN) -m benchmarks run $(ARGS)

faults: .venv/ready  ## damage the core under every claim, and see that it turns red
	$(RUN) -m validation.faults $(ARGS)

fuzz: .venv/ready  ## try to break the core for MINUTES, in processes of their own; totals go to build/fuzz.json
	mkdir -p build
	$(RUN) -m tests.fuzz --minutes $(MINUTES) --out build/fuzz.json $(ARGS)

mutants: .venv/ready  ## mutate the core anywhere, and count how many mutants the claims see
	$(RUN) -m validation.mutants $(ARGS)

matrix: .venv/ready  ## the README's example and a scene's bits on every Python that is here, and on every Numba
	$(RUN) -m tests.matrix --uv $(UV) $(ARGS)

release-check: .venv/ready  ## build wheel and sdist, and be their first user on every Python that is here
	$(RUN) -m tests.release --uv $(UV) $(ARGS)

wheel: .venv/ready  ## build a wheel that brings machine code for this machine's Python: nothing is left to compile
	$(RUN) -m tests.platform_wheel --uv $(UV) $(ARGS)

lint: .venv/ready  ## formatting, lint, types and the walls between the packages
	.venv/bin/ruff format --check .
	.venv/bin/ruff check .
	.venv/bin/lint-imports
	.venv/bin/mypy

PIN := pip compile --quiet --generate-hashes --no-header --no-annotate --universal --python-version 3.11 --all-extras \
	pyproject.toml --output-file requirements.lock

lock: .venv/ready  ## pin what is new in pyproject.toml; other pins stay
	$(UV) $(PIN)

upgrade: .venv/ready  ## pin the newest versions that pyproject.toml allows
	$(UV) $(PIN) --upgrade

clean:  ## remove everything that was made here
	rm -rf .venv .uv build

# The checkout itself is importable from anywhere, by a path file: what runs in examples/ is what stands here.
# pybullet has wheels for CPython 3.10 and 3.11 only: the suite runs on 3.11, the core on any from 3.10 on.
.venv/ready: requirements.lock $(if $(filter .uv/%,$(UV)),.uv/bin/uv)
	$(UV) venv --quiet --clear --python 3.11 .venv
	$(UV) pip sync --quiet --compile-bytecode --require-hashes --python $(RUN) requirements.lock
	$(RUN) -c "import site; print('$(CURDIR)', file=open(site.getsitepackages()[0] + '/softbody.pth', 'w'))"
	touch $@

.uv/bin/uv:
	$(PYTHON) -m venv .uv
	.uv/bin/python -m pip install --quiet --disable-pip-version-check uv==$(UV_VERSION)
