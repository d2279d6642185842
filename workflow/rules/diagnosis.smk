# What is missing: the gap, then a job a candidate, then one verdict.

THRESHOLDS = str(PACKAGE / "diagnosis" / "thresholds.yaml")
DIAGNOSED = {
    "runs": results("runs.csv"),
    "bench": [results("gap.csv"), results("spectra.csv"), results("bursts.csv")],
    "thresholds": THRESHOLDS,
}


rule diagnosis_gap:
    input:
        **DIAGNOSED,
    output:
        results("diagnosis/gap.json"),
    log:
        log_of("diagnosis_gap"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "diagnosis"),
        seed=seed("diagnosis"),
        code=code("diagnosis.conclude", "diagnosis.files", effects=EFFECTS_ON),
    threads: 2
    message:
        "diagnosis: is there a gap"
    shell:  # fits from several starts are its threads; linear algebra has one, as in the verdict
        "OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 NUMBA_NUM_THREADS={threads}"
        " eaclutch --log {log} diagnosis-gap --campaign {params.campaign:q}"
        " --results {params.results:q} --settings {params.settings:q} --seed {params.seed} --output {output:q}"


rule diagnosis_candidate:
    input:
        gap=results("diagnosis/gap.json"),
        **DIAGNOSED,
    output:
        results("diagnosis/candidates/{candidate}.json"),
    log:
        log_of("diagnosis_candidate", "{candidate}"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "diagnosis"),
        seed=seed("diagnosis"),
        code=lambda wildcards: code("diagnosis.study", "diagnosis.files", effects=[*EFFECTS_ON, wildcards.candidate]),
    group:
        "candidates"
    message:
        "diagnosis: weigh {wildcards.candidate}"
    shell:
        "eaclutch --log {log} diagnosis-candidate {wildcards.candidate} --campaign {params.campaign:q}"
        " --results {params.results:q} --settings {params.settings:q} --seed {params.seed} --gap {input.gap:q}"
        " --output {output:q}"


rule diagnosis:
    input:
        gap=results("diagnosis/gap.json"),
        candidates=expand(results("diagnosis/candidates/{candidate}.json"), candidate=CANDIDATES),
        **DIAGNOSED,
    output:
        results("diagnosis/diagnosis.json"),
    log:
        log_of("diagnosis"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "diagnosis"),
        seed=seed("diagnosis"),
        code=code(
            "diagnosis.conclude", "diagnosis.pairs", "diagnosis.files",
            effects=[*EFFECTS_ON, *CANDIDATES, *LOOKALIKES],
        ),
    threads: 2
    message:
        "diagnosis: the verdict"
    shell:  # its threads are processes; linear algebra has one each, for small matrices take longer in two
        "OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1"
        " eaclutch --log {log} diagnosis --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --gap {input.gap:q} --jobs {threads}"
        " --output {output:q} {input.candidates:q}"


rule diagnosis_full:
    input:
        diagnosis=results("diagnosis/diagnosis.json"),
        **DIAGNOSED,
    output:
        table=results("diagnosis/full.json"),
        draws=directory(results("diagnosis/full")),
    log:
        log_of("diagnosis_full"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "diagnosis", "posterior"),
        seed=seed("diagnosis_full"),
        code=code("diagnosis.full", "diagnosis.files", effects=[*EFFECTS_ON, *CANDIDATES]),
    message:
        "diagnosis_full: the finalists, sampled"
    shell:
        "eaclutch --log {log} diagnosis-full --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --diagnosis {input.diagnosis:q}"
        " --draws {output.draws:q} --output {output.table:q}"


rule confusion:
    input:
        capture=capture_file,
        thresholds=THRESHOLDS,
    output:
        results("diagnosis/confusion.json"),
    log:
        log_of("confusion"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        content=lambda wildcards: content("tensile"),
        bench=bench(),
        settings=settings("model", "priors", "diagnosis"),
        seed=seed("confusion"),
        code=code(
            "diagnosis.forecast", "diagnosis.planned", effects=[*EFFECTS_ON, *CANDIDATES, *LOOKALIKES]
        ),
    message:
        "confusion: what this design could tell apart"
    shell:
        "eaclutch --log {log} confusion --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output:q}"
