# What is missing: the gap, then a job a candidate, then one verdict.


rule diagnosis_gap:
    input:
        runs=results("runs.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
    output:
        results("diagnosis/gap.json"),
    log:
        log_of("diagnosis.gate"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "posterior", "diagnosis"),
        seed=seed("diagnosis.gate"),
        code=code("diagnosis.gate", effects=EFFECTS_ON),
    message:
        "diagnosis: is there a gap, and where"
    shell:
        "eaclutch --log {log} diagnosis-gap --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output:q}"


rule diagnosis_candidate:
    input:
        gap=results("diagnosis/gap.json"),
    output:
        results("diagnosis/candidates/{candidate}.json"),
    log:
        log_of("diagnosis_candidate", "{candidate}"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "posterior", "diagnosis"),
        seed=lambda wildcards: seed("diagnosis_candidate", wildcards.candidate),
        code=lambda wildcards: code("diagnosis.weigh", effects=[*EFFECTS_ON, wildcards.candidate]),
    group:
        "candidates"
    message:
        "diagnosis: weigh {wildcards.candidate}"
    shell:
        "eaclutch --log {log} diagnosis-candidate {wildcards.candidate} --campaign {params.campaign:q}"
        " --results {params.results:q} --settings {params.settings:q} --seed {params.seed} --output {output:q}"


rule diagnosis:
    input:
        gap=results("diagnosis/gap.json"),
        candidates=expand(results("diagnosis/candidates/{candidate}.json"), candidate=CANDIDATES),
    output:
        results("diagnosis/diagnosis.json"),
    log:
        log_of("diagnosis"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "posterior", "diagnosis"),
        seed=seed("diagnosis"),
        code=code("diagnosis.conclude", effects=[*EFFECTS_ON, *CANDIDATES]),
    message:
        "diagnosis: the verdict"
    shell:
        "eaclutch --log {log} diagnosis --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output:q} {input.candidates:q}"
