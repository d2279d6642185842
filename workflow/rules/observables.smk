# From recordings to numbers with uncertainties: a job a batch of runs, then one table.


def captured(*_):
    """capture.json once it is there."""
    return json.loads(Path(checkpoints.capture.get().output[0]).read_text(encoding="utf-8"))


def logs_of_batch(wildcards):
    """The recordings of a batch."""
    return [f"{CAMPAIGN}/{entry['path']}" for entry in captured()["runs"] if entry["batch"] == int(wildcards.batch)]


def all_batches(pattern):
    """``pattern`` for every batch that was captured."""
    return lambda wildcards: expand(results(pattern), batch=range(captured()["batches"]))


rule observables:
    input:
        logs=logs_of_batch,
        capture=ancient(results("capture.json")),
    output:
        runs=results("observables/batch_{batch}.csv"),
        published=results("observables/published_{batch}.csv"),
        traces=results("observables/traces_{batch}.npz"),
    log:
        log_of("observables", "batch_{batch}"),
    params:
        campaign=CAMPAIGN,
        bench=bench("substrates", "friction", "load_cell", "drive", "stage_speed", "pad", "film_density"),
        code=code("rig.extract", "rig.published", "rig.traces"),
    group:
        "observables"
    message:
        "observables: batch {wildcards.batch}"
    shell:
        "eaclutch --log {log} observables --campaign {params.campaign:q} --capture {input.capture:q}"
        " --batch {wildcards.batch} --output {output.runs:q} --published {output.published:q} --traces {output.traces:q}"


rule runs:
    input:
        runs=all_batches("observables/batch_{batch}.csv"),
        published=all_batches("observables/published_{batch}.csv"),
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
        code=code("rig.table"),
    message:
        "runs: one table of all runs, with sessions, conditions and exclusions"
    shell:
        "eaclutch --log {log} runs --campaign {params.campaign:q} --settings {params.settings:q}"
        " --output {output.runs:q} --published {output.published:q} --definitions {output.definitions:q}"
        " --quality {output.quality:q} {input.runs:q} {input.published:q}"


rule gap:
    input:
        capacitance=campaign_files("capacitance"),
        permittivity=campaign_files("permittivity"),
        load_cell=campaign_files("load_cell"),
    output:
        gap=results("gap.csv"),
        spectra=results("spectra.csv"),
        bursts=results("bursts.csv"),
    log:
        log_of("gap"),
    params:
        campaign=CAMPAIGN,
        bench=bench("pad", "fixture"),
        settings=settings("posterior.capacitance_widths_mm", "posterior.capacitance_force_max_n"),
        code=code("rig.gap", "rig.capacitance", "rig.spectra", "rig.load_cell"),
    message:
        "gap: capacitance readings, permittivity spectra and load-cell bursts"
    shell:
        "eaclutch --log {log} gap --campaign {params.campaign:q} --settings {params.settings:q}"
        " --gap {output.gap:q} --spectra {output.spectra:q} --bursts {output.bursts:q}"
