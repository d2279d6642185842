# Are the posteriors what they say? Simulation-based calibration on the campaign's layout; about an hour on two cores.
SBC_PARTS = 10


rule sbc_part:
    input:
        runs=results("runs.csv"),
        bursts=results("bursts.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
    output:
        temp(results("sbc/{stage}/part_{part}.json")),
    log:
        log_of("sbc", "{stage}_{part}"),
    wildcard_constraints:
        part=r"\d+",
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        replications=CONFIG["posterior"]["calibration_replications"],
        parts=SBC_PARTS,
        bench=bench(),
        settings=settings("model", "posterior", "priors"),
        seed=lambda wildcards: seed("sbc", wildcards.stage),
        code=code("inference.replicable", effects=EFFECTS_ON),
    group:
        "sbc"
    message:
        "sbc: {wildcards.stage}, part {wildcards.part}"
    shell:
        "eaclutch --log {log} sbc {wildcards.stage} --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --replications {params.replications} --part {wildcards.part}"
        " --parts {params.parts} --output {output:q}"


rule agreement:
    input:
        runs=results("runs.csv"),
        bursts=results("bursts.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
    output:
        results("sbc/agreement_{stage}.json"),
    log:
        log_of("agreement", "{stage}"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "posterior", "priors"),
        seed=lambda wildcards: seed("agreement", wildcards.stage),
        code=code("inference.agreement", "inference.posterior", effects=EFFECTS_ON),
    message:
        "agreement: {wildcards.stage} by another sampler"
    shell:
        "eaclutch --log {log} agreement {wildcards.stage} --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output:q}"


rule sbc:
    input:
        ranks=expand(results("sbc/{stage}/part_{part}.json"), stage=STAGES, part=range(SBC_PARTS)),
        agreement=expand(results("sbc/agreement_{stage}.json"), stage=STAGES),
    output:
        results("sbc/calibration.json"),
    log:
        log_of("sbc"),
    params:
        seed=seed("sbc"),
        code=code("inference.calibration"),
    message:
        "sbc: verdicts by stage"
    shell:
        "eaclutch --log {log} sbc-summary --seed {params.seed} --output {output:q} {input.ranks:q}"


rule published_fits:
    input:
        runs=results("runs.csv"),
        bursts=results("bursts.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
    output:
        results("posterior/published_fits.csv"),
    log:
        log_of("published_fits"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "posterior", "priors"),
        seed=seed("published_fits"),
        code=code("inference.choices", effects=EFFECTS_ON),
    message:
        "published_fits: the paper's point fits by its own choices and by others"
    shell:
        "eaclutch --log {log} published-fits --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output:q}"
