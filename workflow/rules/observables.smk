# From recordings to numbers with uncertainties: a job a batch of runs, then one table; and the benches beside the rig.


def all_batches(*patterns):
    """The patterns for every batch that was captured."""
    return lambda wildcards: expand([results(pattern) for pattern in patterns], batch=captured()["batches"])


def runs_of(batch):
    """Names of the runs of a batch."""
    return {entry["run"] for entry in captured()["runs"] if entry["batch"] == int(batch)}


def exclusions(batch):
    """campaign.yaml's reasons for leaving out runs of the batch, so that dropping a run reruns its batch only."""
    return json.dumps({run: BENCH.exclude[run] for run in sorted(runs_of(batch)) if run in BENCH.exclude})


rule observables:
    input:
        capture=capture_file,
    output:
        runs=results("observables/batch_{batch}.csv"),
        published=results("observables/published_{batch}.csv"),
        traces=results("observables/traces_{batch}.npz"),
    log:
        log_of("observables", "batch_{batch}"),
    params:
        campaign=CAMPAIGN,
        content=lambda wildcards: content(runs=runs_of(wildcards.batch)),
        exclude=lambda wildcards: exclusions(wildcards.batch),
        bench=bench("substrates", "friction", "load_cell", "drive", "stage_speed", "pad", "film_density"),
        code=code("rig.batch", "rig.published", "rig.traces", "cli.rig"),
    group:
        "observables"
    message:
        "observables: batch {wildcards.batch}"
    shell:
        "eaclutch --log {log} observables --campaign {params.campaign:q} --capture {input.capture:q}"
        " --batch {wildcards.batch} --output {output.runs:q} --published {output.published:q} --traces {output.traces:q}"


rule runs:
    input:
        all_batches("observables/batch_{batch}.csv", "observables/published_{batch}.csv"),
    output:
        runs=results("runs.csv"),
        published=results("runs_published.csv"),
        definitions=results("observables.json"),
        quality=results("quality.json"),
    log:
        log_of("runs"),
    params:
        campaign=CAMPAIGN,
        bench=bench(),
        settings=settings("observables.preload_bin_edges_n", "observables.exclude"),
        code=code("rig.batch", "rig.published", "rig.table", "rig.campaign", "cli.rig"),
    message:
        "runs: one table of all runs, with sessions, conditions and exclusions"
    shell:
        "eaclutch --log {log} runs --campaign {params.campaign:q} --settings {params.settings:q}"
        " --output {output.runs:q} --published {output.published:q} --definitions {output.definitions:q}"
        " --quality {output.quality:q} {input:q}"


rule gap:
    input:
        capture=capture_file,
    output:
        gap=results("gap.csv"),
        spectra=results("spectra.csv"),
        bursts=results("bursts.csv"),
    log:
        log_of("gap"),
    params:
        campaign=CAMPAIGN,
        content=lambda wildcards: content("capacitance", "permittivity", "load_cell"),
        bench=bench("pad", "fixture", "substrates"),
        settings=settings("posterior.capacitance_widths_mm", "posterior.capacitance_force_max_n"),
        code=code("rig.gap", "rig.capacitance", "rig.spectra", "rig.load_cell", "rig.campaign", "cli.rig"),
    message:
        "gap: capacitance readings as gaps, permittivity spectra, free swings of the load cell"
    shell:
        "eaclutch --log {log} gap --campaign {params.campaign:q} --settings {params.settings:q}"
        " --gap {output.gap:q} --spectra {output.spectra:q} --bursts {output.bursts:q}"
