# Calibrated parameters: three stages on their own data, then the force given draws of the others.
STAGES = ("contact", "dielectric", "load_cell", "force")

# What a stage reads besides the campaign, the bench's facts it rests on, and its own part of the library.
STAGE_INPUTS = {
    "dielectric": [],
    "contact": [results("posterior/dielectric.nc")],
    "load_cell": [results("bursts.csv")],
    "force": [results("runs.csv"), *(results(f"posterior/{stage}.nc") for stage in STAGES[:3])],
}
# A prior of another stage's parameter does not rerun a stage; the force stage owns those that no other has.
STAGE_PARAMETERS = {
    "contact": {
        "contact_stiffness", "roughness_sd", "stray_capacitance", "film_thickness", "capacitance_noise", "trial_spread",
        "width_spread",
    },
    "dielectric": {
        "kappa_static", "kappa_infinity", "relaxation_time", "cole_cole_exponent", "spectrum_noise", "source_spread",
    },
    "load_cell": {"stiffness", "mass", "damping", "frequency_spread", "damping_spread"},
}
STAGE_PARAMETERS["force"] = set(CONFIG["priors"]) - set().union(*STAGE_PARAMETERS.values())
STAGE_FOLDERS = {"contact": ["capacitance"], "dielectric": ["permittivity"], "load_cell": ["load_cell"], "force": []}
STAGE_BENCH = {
    "contact": ("pad", "film_density", "fixture", "substrates"),
    "dielectric": ("fixture",),
    "load_cell": ("load_cell",),
    "force": ("pad", "film_density", "fixture", "substrates", "friction", "load_cell", "drive", "stage_speed"),
}


rule posterior:
    input:
        results=lambda wildcards: STAGE_INPUTS[wildcards.stage],
        capture=capture_file,
    output:
        draws=results("posterior/{stage}.nc"),
        gate=results("posterior/{stage}.gate.json"),
    log:
        log_of("posterior", "{stage}"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        content=lambda wildcards: content(*STAGE_FOLDERS[wildcards.stage]),
        bench=lambda wildcards: bench(*STAGE_BENCH[wildcards.stage]),
        settings=lambda wildcards: settings(
            *(["model", "posterior"] if wildcards.stage == "force" else ["posterior"]),
            priors=STAGE_PARAMETERS[wildcards.stage],
        ),
        seed=lambda wildcards: seed("posterior", wildcards.stage),
        code=lambda wildcards: code("inference.posterior", effects=EFFECTS_ON),
    message:
        "posterior: sample {wildcards.stage}"
    shell:
        "eaclutch --log {log} posterior {wildcards.stage} --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output.draws:q} --gate {output.gate:q}"


rule posterior_summary:
    input:
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
        gates=expand(results("posterior/{stage}.gate.json"), stage=STAGES),
    output:
        summary=results("posterior/summary.json"),
        sensitivity=results("posterior/sensitivity.json"),
    log:
        log_of("posterior_summary"),
    params:
        code=code("inference.summary"),
    message:
        "posterior: table of all stages"
    shell:
        "eaclutch --log {log} posterior-summary --output {output.summary:q}"
        " --sensitivity {output.sensitivity:q} {input.draws:q}"
