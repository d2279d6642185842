# Conventions of all rules: the config, path patterns, slices, seeds. Stated once, used by every stage.
import csv
import hashlib
import json
import os
import shutil
import sys
import time
from pathlib import Path

import eaclutch
from eaclutch.config import load_bench, load_config
from eaclutch.config.slices import bench_slice, job_seed
from eaclutch.physics.effects import EFFECTS, LOOKALIKES, NAMED, switched_on
from eaclutch.files import hold, read_json
from eaclutch.provenance import code_hash
from eaclutch.records import InputError
from eaclutch.manifest import refuse_other_campaign

STARTED = time.time()
CHECKOUT = Path(workflow.basedir)
PACKAGE = Path(eaclutch.__file__).parent


def stop(error):
    """One line and out, before a DAG is built."""
    print(f"eaclutch: error: {error}", file=sys.stderr)
    sys.exit(1)


try:
    CONFIG = load_config(
        workflow.config_settings.configfiles or [CHECKOUT / "config" / "config.yaml"], workflow.config_settings.config
    )
    CAMPAIGN = CONFIG["campaign"]
    BENCH = load_bench(CAMPAIGN)
    RESULTS = f"results/{BENCH.name}"
    refuse_other_campaign(CAMPAIGN, RESULTS)
except InputError as error:
    stop(error)

# The environment's own commands first; one thread a job unless the rule asks for more.
os.environ["PATH"] = os.pathsep.join([os.path.dirname(sys.executable), os.environ.get("PATH", "")])
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"


# Other runs are kept from these results before this one looks at what is there: files that go while Snakemake looks
# end it with a line of its own. Jobs belong to the run that holds them; a dry run changes nothing.
if workflow.is_main_process and not workflow.output_settings.dryrun:
    try:
        hold(f".snakemake/eaclutch/{BENCH.name}.lock")  # free again when this process ends, however it ends
    except BlockingIOError:
        stop(InputError(RESULTS, "another run makes these results", "wait for it, or use another --directory"))
    except OSError as error:
        stop(InputError(".snakemake", f"cannot be written ({error.strerror})", "use a --directory that can"))


def date_results():
    """Set what comes from the future to now: after the clock was set back, outputs would be older than inputs."""
    now = time.time()
    for path in Path(RESULTS).rglob("*"):
        if path.is_file() and path.stat().st_mtime > now:
            os.utime(path, (now, now))


def results(pattern):
    """A path pattern below the campaign's results folder."""
    return f"{RESULTS}/{pattern}"


def log_of(rule_name, wildcards=""):
    """Where a rule logs: its name and its wildcards."""
    return results(f"logs/{rule_name}/{wildcards or rule_name}.log")


def numbers(name):
    """A JSON file of the results, for the captions of ``snakemake --report``."""
    return read_json(results(name))


def table(name):
    """The rows of a CSV file of the results as dictionaries of text, for captions."""
    with open(results(name), newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


# Captions are rendered long after the rules: they reach the results through the config, the only thing they share.
config |= {"numbers": numbers, "table": table}


def settings(*keys, priors=None):
    """JSON of those parts of the config (``model``, ``posterior.walkers``); the rule reruns when they change.

    ``priors``: names of parameters whose priors from the config go along.
    """
    part = {}
    if priors is not None:
        part["priors"] = {name: prior for name, prior in CONFIG["priors"].items() if name in priors}
    for key in keys:
        value = CONFIG
        for name in key.split("."):
            value = value[name]
        part[key] = value
    return json.dumps(part, sort_keys=True)


def bench(*parts):
    """The named facts of campaign.yaml as text; the rule reruns when one of them changes."""
    return bench_slice(BENCH, parts)


def code(*modules, effects=()):
    """Hash of the library's parts that a rule depends on; the rule reruns when one of them changes."""
    return code_hash(modules, effects)


# Names of the effects that the model has, and of those that compete to explain what it lacks.
EFFECTS_ON = switched_on(CONFIG["model"])
CANDIDATES = [
    name for name in CONFIG["diagnosis"]["candidates"] or NAMED if name not in EFFECTS_ON
]


def seed(*labels):
    """The seed of a job, from the config's seed and what tells the job from others."""
    return job_seed(CONFIG["seed"], labels)


def job_error():
    """The first error line that a job of this call left in its log, or None."""
    logs = [path for path in Path(RESULTS, "logs").rglob("*.log") if path.stat().st_mtime >= STARTED - 1]
    for path in sorted(logs, key=lambda path: path.stat().st_mtime):
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("eaclutch: error:"):
                return line
    # a full disk takes the logs' lines too
    if shutil.disk_usage(".").free < 1_000_000:
        return f"eaclutch: error: {Path.cwd()}: the disk is full; make room and start again"
    return None
