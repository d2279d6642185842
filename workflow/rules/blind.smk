# The sealed benchmark: campaigns whose effect is withheld, diagnosed, frozen, and only then opened.
# Answers lie in a folder of their own, which no rule reads but the one that makes campaigns and the one that scores.
from eaclutch.blind.comparators import COMPARATORS
from eaclutch.blind.sizes import SIZES

BLIND = "results/blind"
ANSWERS = "results/blind-answers"
METHODS = CONFIG["blind"]["methods"]
SCORED = [*METHODS, *CONFIG["blind"]["rivals"]]


def batches_of(pattern):
    """The pattern once a batch of the size."""
    return lambda wildcards: [
        pattern.format(**wildcards, batch=batch) for batch in range(SIZES[wildcards.size].batches)
    ]


def diagnosed_by(wildcards):
    """What must be there before a method's verdicts are frozen; a rival's come from elsewhere."""
    if wildcards.method in COMPARATORS:
        return f"{BLIND}/{wildcards.size}/diagnosed/{wildcards.method}/all.json"
    if wildcards.method in METHODS:
        return batches_of(f"{BLIND}/{{size}}/diagnosed/{wildcards.method}/{{batch}}.json")(wildcards)
    return []


def open_seed(wildcards):
    """The option that makes a set open and reproducible, where it is meant to be."""
    chosen = CONFIG["seed"] if wildcards.size == "blind_small" else CONFIG["blind"]["seed"]
    return "" if chosen is None else f"--seed {chosen}"


rule blind_plan:
    output:
        f"{ANSWERS}/{{size}}/plan.json",
    log:
        f"{BLIND}/logs/plan/{{size}}.log",
    params:
        seed=open_seed,
        limits=f"--limits {CONFIG['blind']['limits']}" if CONFIG["blind"]["limits"] else "",
    message:
        "blind: draw the plan of {wildcards.size}"
    shell:
        "eaclutch --log {log} blind plan --size {wildcards.size} {params.seed} {params.limits} --output {output:q}"


rule blind_seal:
    input:
        ancient(f"{ANSWERS}/{{size}}/plan.json"),
    output:
        cases=directory(f"{BLIND}/{{size}}/cases/{{batch}}"),
        commitments=f"{BLIND}/{{size}}/commitments/{{batch}}.json",
        answers=f"{ANSWERS}/{{size}}/answers_{{batch}}.json",
    log:
        f"{BLIND}/logs/seal/{{size}}_{{batch}}.log",
    message:
        "blind: seal batch {wildcards.batch} of {wildcards.size}"
    shell:
        "eaclutch --log {log} blind seal --plan {input:q} --batch {wildcards.batch} --cases {output.cases:q}"
        " --commitments {output.commitments:q} --answers {output.answers:q}"


wildcard_constraints:
    size="|".join(SIZES),
    method="[a-z][a-z0-9_-]*",


rule blind_diagnose:
    input:
        cases=f"{BLIND}/{{size}}/cases/{{batch}}",
        commitments=f"{BLIND}/{{size}}/commitments/{{batch}}.json",
    output:
        f"{BLIND}/{{size}}/diagnosed/{{method}}/{{batch}}.json",
    wildcard_constraints:
        method="library|without-[a-z_]+",
    log:
        f"{BLIND}/logs/diagnose/{{size}}_{{method}}_{{batch}}.log",
    params:
        verdicts=f"{BLIND}/{{size}}/verdicts/{{method}}",
        fits=lambda wildcards: (
            f"--fits {BLIND}/{wildcards.size}/fits" if wildcards.method == "library" else ""
        ),
        settings=settings("model", "priors", "diagnosis"),
        seed=seed("blind_diagnose"),
        code=code("diagnosis.conclude", "diagnosis.pairs", "rig.batch", effects=list(EFFECTS)),
    message:
        "blind: {wildcards.method} on batch {wildcards.batch} of {wildcards.size}"
    shell:
        "eaclutch --log {log} blind diagnose --commitments {input.commitments:q} --cases {input.cases:q}"
        " --method {wildcards.method} --settings {params.settings:q} --seed {params.seed} --code {params.code}"
        " --verdicts {params.verdicts:q} {params.fits} --output {output:q}"


rule blind_compare:
    input:
        commitments=batches_of(f"{BLIND}/{{size}}/commitments/{{batch}}.json"),
        fits=batches_of(f"{BLIND}/{{size}}/diagnosed/library/{{batch}}.json"),
    output:
        f"{BLIND}/{{size}}/diagnosed/{{method}}/all.json",
    wildcard_constraints:
        method="|".join(COMPARATORS),
    log:
        f"{BLIND}/logs/compare/{{size}}_{{method}}.log",
    params:
        verdicts=f"{BLIND}/{{size}}/verdicts/{{method}}",
        fits=f"{BLIND}/{{size}}/fits",
        code=code("blind.comparators"),
    message:
        "blind: {wildcards.method} on {wildcards.size}"
    shell:
        "eaclutch --log {log} blind compare --fits {params.fits:q} --method {wildcards.method}"
        " --verdicts {params.verdicts:q} --output {output:q} {input.commitments:q}"


rule blind_freeze:
    input:
        commitments=batches_of(f"{BLIND}/{{size}}/commitments/{{batch}}.json"),
        diagnosed=diagnosed_by,
    output:
        f"{BLIND}/{{size}}/frozen/{{method}}.json",
    log:
        f"{BLIND}/logs/freeze/{{size}}_{{method}}.log",
    params:
        verdicts=f"{BLIND}/{{size}}/verdicts/{{method}}",
    message:
        "blind: freeze the verdicts of {wildcards.method} on {wildcards.size}"
    shell:
        "eaclutch --log {log} blind freeze --verdicts {params.verdicts:q} --output {output:q} {input.commitments:q}"


rule blind_unseal:
    input:
        commitments=batches_of(f"{BLIND}/{{size}}/commitments/{{batch}}.json"),
        frozen=expand(f"{BLIND}/{{{{size}}}}/frozen/{{method}}.json", method=SCORED),
        answers=batches_of(f"{ANSWERS}/{{size}}/answers_{{batch}}.json"),
    output:
        f"{BLIND}/{{size}}/score.json",
    log:
        f"{BLIND}/logs/unseal/{{size}}.log",
    params:
        commitments=lambda wildcards, input: " ".join(f"--commitments {path}" for path in input.commitments),
        frozen=lambda wildcards, input: " ".join(f"--frozen {path}" for path in input.frozen),
        answers=lambda wildcards, input: " ".join(f"--answers {path}" for path in input.answers),
        verdicts=f"{BLIND}/{{size}}/verdicts",
        opened=f"{ANSWERS}/{{size}}/opened.json",
        forecast=f"--forecast {CONFIG['blind']['forecast']}" if CONFIG["blind"]["forecast"] else "",
        code=code("blind.scoring"),
    message:
        "blind: open the answers of {wildcards.size} and score"
    shell:
        "eaclutch --log {log} blind unseal {params.commitments} {params.frozen} {params.answers}"
        " --verdicts {params.verdicts:q} --opened {params.opened:q} {params.forecast} --output {output:q}"


rule blind_report:
    input:
        f"{BLIND}/{{size}}/score.json",
    output:
        f"{BLIND}/{{size}}/report.html",
    log:
        f"{BLIND}/logs/report/{{size}}.log",
    params:
        newest=f"{BLIND}/report.html",
        code=code("reporting.blind_page"),
    message:
        "blind: the page of {wildcards.size}"
    shell:
        "eaclutch --log {log} blind report --score {input:q} --newest {params.newest:q} --output {output:q}"


for name in SIZES:

    rule:
        name:
            name
        input:
            f"{BLIND}/{name}/report.html",


rule seal:
    input:
        expand(
            f"{BLIND}/{CONFIG['blind']['size']}/commitments/{{batch}}.json",
            batch=range(SIZES[CONFIG["blind"]["size"]].batches),
        ),


rule unseal:
    input:
        f"{BLIND}/{CONFIG['blind']['size']}/report.html",
