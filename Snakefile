# From a folder of recordings to a diagnosis and a report. Rules call the installed package; see docs/architecture.md.
from snakemake.utils import min_version

min_version("9.0")


include: "workflow/rules/common.smk"
include: "workflow/rules/fixture.smk"
include: "workflow/rules/capture.smk"
include: "workflow/rules/observables.smk"
include: "workflow/rules/posterior.smk"
include: "workflow/rules/predict.smk"
include: "workflow/rules/calibration.smk"
include: "workflow/rules/diagnosis.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/blind.smk"


wildcard_constraints:
    batch=r"\d+",
    stage="contact|dielectric|load_cell|force",


rule all:
    default_target: True
    input:
        results("report.html"),
        results("manifest.json"),


onstart:
    date_results()


onerror:
    line = job_error()
    if line:
        print(line, file=sys.stderr)
