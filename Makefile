# Everything runs in .venv, made with plain pip from pinned constraints. PYTHON picks the interpreter (>= 3.11).
PYTHON ?= python3
V := .venv/bin
STAMP := .venv/.installed
DEMO := .venv/.demo

# every process would compile all its modules anew, and each of hundreds in the tests does
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-ci test-long branches test-fast test-numba test-vcan test-web web-pictures test-c wheel wheel-test sbom check format lint types docs site examples bench latency trials soak soak-wall clean fuzz fuzz-estimator fuzz-c attack audit mutants golden

demo: $(DEMO)  ## run the main job in this terminal
	$(V)/vegrip demo

# one more than there are processors: many tests wait for processes that they have started; 0: none beside make
WORKERS ?= $(shell expr $$(nproc) + 1)

# the workers share the processors already; BLAS with threads of its own beside them costs a quarter more
test test-ci test-long test-fast test-numba test-vcan test-c: export OPENBLAS_NUM_THREADS = 1

test: WHICH = not wheel and not long and not numba
test-ci: WHICH = not wheel and not numba
TESTS = $(V)/python -m pytest -q -m "$(WHICH)"
ALL_TESTS = $(TESTS) -n $(WORKERS) --dist worksteal
FAILED = .pytest_cache/v/cache/lastfailed

test: $(STAMP)  ## pass the tests
	$(ALL_TESTS)

test-ci: $(STAMP)  ## the same with the longest; up to five tests that fail are told, and run once more, alone: the machine may have been late for them
	@rm -f $(FAILED)
	@$(ALL_TESTS) || { code=$$?; [ $$code = 1 ] && [ $$(grep -c :: $(FAILED)) -le 5 ] || exit $$code; \
	  echo "FAILED AT FIRST, and run once more, alone:"; grep :: $(FAILED); $(TESTS) -n 0 --last-failed; }

test-long: $(STAMP)  ## tests that take the longest, and those of many trials for one figure
	$(V)/python -m pytest -q -n auto --dist load -m long $$(grep -rl --include='*.py' mark.long tests)

branches: $(STAMP)  ## branch coverage of the safety path: watchdog, fail-safe, limits, renewal, decoding; one that no test takes fails
	$(V)/python -m tools.safety_branches

test-fast: $(STAMP)
	$(V)/python -m pytest -q -n $(WORKERS) -m "not slow and not long and not wheel and not numba"

# those that compare numba with plain Python to the bit, and what is odd: statistics are then those of C
OF_KERNELS = $(addprefix tests/estimator/test_,estimate.py hostile.py ieee.py memory.py allocation.py late.py hold.py) \
  tests/grip/compiled tests/grip/test_controller.py tests/grip/test_hostile.py tests/grip/test_model_swap.py \
  tests/c99/test_estimator.py tests/c99/test_kernel_mode.py tests/c99/test_single.py
test-numba: $(STAMP)  ## tests of estimator and grip with both compiled by numba; the others take C
	VEGRIP_KERNEL=numba $(V)/python -m pytest -q -n $(WORKERS) --dist worksteal -m "not long and not other_model" $(OF_KERNELS)

test-vcan: $(STAMP)  ## the tests over a real kernel's SocketCAN; fetches User-Mode-Linux where this kernel has none
	$(V)/python tests/vcan/compile_first.py  # here: in there it would take minutes
	tests/vcan/run $(V)/python -m pytest -q -p no:cacheprovider tests/vcan tests/canopen/test_with_canopen.py tests/canopen/test_trouble.py

test-c: $(STAMP)  ## the estimator in C against plain Python, every effect; the export with gcc, clang, sanitizers, cppcheck, MISRA, emulated Cortex-M7 and M4F
	$(V)/python -m pytest -q -n auto tests/c99 tests/export

test-web: $(STAMP)  ## the pages in a real browser, headless: Chromium of the distribution (apt-get install chromium)
	VEGRIP_WEB_TESTS=1 $(V)/python -m pytest -q -n 0 -m browser tests/web

web-pictures: $(STAMP)  ## draw docs/images/web-*.png and live.webp again, on a quiet machine; more are in build/web-pictures
	mkdir -p build/web-pictures
	VEGRIP_WEB_TESTS=1 VEGRIP_SCREENSHOTS=$(CURDIR)/build/web-pictures $(V)/python -m pytest -q -n 0 -m browser tests/web
	cp build/web-pictures/web-live.png build/web-pictures/web-check.png build/web-pictures/web-calibrate.png docs/images
	$(V)/python docs/live_picture.py

wheel-test: $(STAMP)  ## the built wheel in a clean environment without extras, outside the checkout
	$(V)/python -m pytest -q -n 0 tests/install

wheel: $(STAMP)  ## dist/: sources and wheel, dated as the last commit, so that whoever builds the commit gets the same wheel
	SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct) $(V)/python -m build --no-isolation

sbom: $(STAMP)  ## build/vegrip.cdx.json: all pinned parts, as CycloneDX
	mkdir -p build
	$(V)/python -m tools.sbom > build/vegrip.cdx.json

check: lint types test test-long branches test-web test-numba test-vcan docs examples site wheel-test  ## what CI runs

format: $(STAMP)
	$(V)/ruff format .
	$(V)/ruff check --fix .
	$(V)/python -m tools.write_eds proto

lint: $(STAMP)
	$(V)/ruff format --check .
	$(V)/ruff check .

# mypy wants to see the package laid out as the wheel lays it out, and beside it what is not installed
TYPES ?= build/types
types: $(STAMP)
	$(V)/python -m tools.write_declarations
	mkdir -p $(TYPES)/vegrip && find $(TYPES) -type l -delete
	ln -s $(CURDIR)/benchmarks $(CURDIR)/tools $(CURDIR)/validation $(TYPES)/
	ln -s $(CURDIR)/vegrip/* $(CURDIR)/nodes $(CURDIR)/proto $(CURDIR)/launch $(TYPES)/vegrip/
	cd $(TYPES) && $(CURDIR)/$(V)/mypy --config-file $(CURDIR)/pyproject.toml -p vegrip -p benchmarks -p tools -p validation

docs: $(STAMP)
	$(V)/python docs/check.py

SITE := .venv/.site
site: $(SITE)  ## the documents as pages in build/site: warnings are errors, nothing is loaded from elsewhere
	NO_MKDOCS_2_WARNING=1 PYTHONPATH=. $(V)/mkdocs build --strict
	$(V)/python docs/site/check.py build/site
	@echo "open build/site/index.html; its search needs a server: python3 -m http.server -b 127.0.0.1 -d build/site 8000"

$(SITE): $(STAMP)
	$(V)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[site]'
	touch $@

NOTEBOOK := .venv/.notebook
examples: $(NOTEBOOK)  ## run every example, and the notebooks
	$(V)/python examples/run_all.py

$(NOTEBOOK): $(STAMP)
	$(V)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[notebook]'
	touch $@

fuzz-estimator: $(STAMP)  ## a million hostile samples through estimator and node (3 minutes)
	VEGRIP_FUZZ=250000 $(V)/python -m pytest -q -n auto tests/estimator/test_hostile.py tests/grip/test_hostile.py

FUZZ_FRAMES ?= 1000000
FUZZ_SEED ?= 26
fuzz-c: $(STAMP)  ## random and hostile frames, times, saves and settings: exported C under sanitizers against Python (a million frames: 20 minutes)
	VEGRIP_FUZZ_C=$(FUZZ_FRAMES) VEGRIP_FUZZ_SEED=$(FUZZ_SEED) $(V)/python -m pytest -q -n 0 --log-cli-level=INFO \
	  tests/export/test_differential.py -k test_no_order_makes_a_difference

FUZZ_SECONDS ?= 60
fuzz: $(STAMP)  ## look for bytes that break a decoder, guided by coverage
	$(V)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[fuzz]'
	mkdir -p build/fuzz
	$(V)/python tests/security/decoders.py -max_total_time=$(FUZZ_SECONDS) -timeout=5 -max_len=600 \
	  -artifact_prefix=build/fuzz/ build/fuzz

ATTACK_SECONDS ?= 300
ATTACK_SEED ?= 0
attack: $(STAMP)  ## break files of every kind, then what goes over the wires (ATTACK_SECONDS=300 for each, ATTACK_SEED=0); files that failed: build/attack
	$(V)/python tests/attack/readers --seconds $(ATTACK_SECONDS) --seed $(ATTACK_SEED)
	$(V)/python tests/attack/wire --seconds $(ATTACK_SECONDS) --seed $(ATTACK_SEED)

MUTANTS ?=
mutants: $(STAMP)  ## change one operator or number at a time: does a test fail? At most a minute of the processor for each, and goes on from the last run (MUTANTS="--seed 1 --only contact")
	nice $(V)/python tools/mutants.py $(MUTANTS)

AUDIT := build/audit/bin
audit:  ## look for known vulnerabilities in the pinned dependencies, with pip-audit; needs a network
	$(PYTHON) -m venv build/audit
	@$(AUDIT)/python -m pip install --quiet --disable-pip-version-check pip-audit==2.10.1 2>/dev/null \
	  || { echo "audit: pip-audit cannot be installed from here; run this where pip reaches its index" >&2; exit 1; }
	@$(AUDIT)/pip-audit --strict --no-deps --disable-pip -r constraints.txt 2>build/audit/complaints; code=$$?; \
	  if grep -q 'ConnectionError\|HTTPError\|Timeout\|ServiceError' build/audit/complaints; then \
	    echo "audit: the list of known vulnerabilities does not answer here; run this where it does" >&2; exit 1; fi; \
	  cat build/audit/complaints >&2; exit $$code

GOLDEN ?=
golden: $(STAMP)  ## run all cases of the golden answers: does anything answer otherwise than validation/golden.json says? (GOLDEN=--quick)
	OPENBLAS_NUM_THREADS=1 $(V)/python -m validation.golden $(GOLDEN)

bench: $(STAMP)
	$(V)/vegrip bench

INSTALL = $(PYTHON) -c 'import sys; sys.exit("vegrip needs Python >= 3.11, set PYTHON=..." if sys.version_info < (3, 11) else 0)' \
	&& $(PYTHON) -m venv .venv \
	&& $(V)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e

$(DEMO): pyproject.toml setup.py constraints.txt  # what the demonstration needs and no more
	@echo "installing what the demo needs into .venv (about a minute)"
	@$(INSTALL) '.[plot,web]'
	@touch $@

$(STAMP): pyproject.toml setup.py constraints.txt
	$(INSTALL) '.[dev]'
	touch $(DEMO) $@

latency: $(STAMP)  ## state in to command out against an echo, over every link (5 minutes on a quiet machine)
	$(V)/python -m benchmarks._latency_matrix

trials: $(STAMP)  ## how often a diagnosis names what was hidden: 200 recordings, an hour; goes on where it was stopped
	mkdir -p build
	$(V)/python -m validation.diagnosis_trials -n 200 --jobs 2 -o build/trials.jsonl --seed 12

soak: $(STAMP)  ## an hour of holding under faults, in simulated time
	$(V)/python -m validation.faults --soak 3600

soak-wall: $(STAMP)  ## four minutes of real processes that are killed, stopped and babbled at
	$(V)/python -m validation.faults --wall 240

clean:
	rm -rf .venv build dist *.egg-info
