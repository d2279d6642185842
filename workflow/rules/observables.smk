# From recordings to numbers with uncertainties: a job a batch of runs, then one table; and the benches beside the rig.


def captured_runs():
    """capture.json, once it is there."""
    return json.loads(Path(checkpoints.capture.get().output[0]).read_text(encoding="utf-8"))


def runs_of(wildcards):
    """The entries of a batch's runs."""
    return [entry for entry in captured_runs()["runs"] if entry["batch"] == int(wildcards.batch)]


def all_batches(pattern):
    """``pattern`` for every batch that was captured."""
    return lambda wildcards: expand(results(pattern), batch=captured_runs()["batches"])


def exclusions(wildcards):
    """Reasons of the batch's runs that are left out, so that dropping a run reruns its own batch only."""
    left_out = {**BENCH.exclude, **CONFIG["observables"]["exclude"]}
    return json.dumps({e["run"]: left_out[e["run"]] for e in runs_of(wildcards) if e["run"] in left_out}, sort_keys=True)


rule observables:
    input:
        logs=lambda wildcards: [f"{CAMPAIGN}/{entry['file']}" for entry in runs_of(wildcards)],
        capture=ancient(results("capture.json")),
    output:
        runs=results("observables/batch_{batch}.csv"),
        traces=results("observables/traces_{batch}.npz"),
    log:
        log_of("observables", "batch_{batch}"),
    params:
        campaign=CAMPAIGN,
        exclude=exclusions,
        bench=bench("substrates", "friction", "load_cell", "drive", "stage_speed", "pad", "film_density"),
        code=code("rig.batch", "rig.traces"),
    group:
        "observables"
    message:
        "observables: batch {wildcards.batch}"
    shell:
        "eaclutch --log {log} extract {params.campaign:q} --capture {input.capture:q} --batch {wildcards.batch}"
        " --exclude {params.exclude:q} --traces {output.traces:q} --out {output.runs:q}"


rule runs:
    input:
        all_batches("observables/batch_{batch}.csv"),
    output:
        runs=results("runs.csv"),
        observables=results("observables.json"),
        quality=results("quality.json"),
    log:
        log_of("runs"),
    params:
        campaign=CAMPAIGN,
        bench=bench(),
        preload_edges=json.dumps(CONFIG["observables"]["preload_bin_edges_n"]),
        exclude=json.dumps(CONFIG["observables"]["exclude"], sort_keys=True),
        code=code("rig.batch"),
    message:
        "runs: one table of all runs, with sessions, conditions and exclusions"
    shell:
        "eaclutch --log {log} join {params.campaign:q} --runs {output.runs:q} --observables {output.observables:q}"
        " --quality {output.quality:q} --preload-edges {params.preload_edges:q} --exclude {params.exclude:q} {input:q}"


rule gap:
    input:
        campaign_files("capacitance"),
    output:
        results("gap.csv"),
    log:
        log_of("gap"),
    params:
        campaign=CAMPAIGN,
        bench=bench("pad", "fixture", "substrates"),
        code=code("rig.gap", "rig.capacitance"),
    message:
        "gap: capacitance readings as gaps"
    shell:
        "eaclutch --log {log} gap {params.campaign:q} --out {output:q}"


rule spectra:
    input:
        campaign_files("permittivity"),
    output:
        results("spectra.csv"),
    log:
        log_of("spectra"),
    params:
        campaign=CAMPAIGN,
        code=code("rig.spectra"),
    message:
        "spectra: permittivity of the film, all sources"
    shell:
        "eaclutch --log {log} spectra {params.campaign:q} --out {output:q}"


rule bursts:
    input:
        campaign_files("load_cell"),
    output:
        results("bursts.csv"),
    log:
        log_of("bursts"),
    params:
        campaign=CAMPAIGN,
        code=code("rig.load_cell"),
    message:
        "bursts: free swings of the load cell"
    shell:
        "eaclutch --log {log} bursts {params.campaign:q} --out {output:q}"
