# What the calibrated model says of every run, on draws and on left-out conditions.


rule predict:
    input:
        runs=results("runs.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
        summary=results("posterior/summary.json"),
    output:
        runs=report(results("predict/runs.csv"), caption="../report/predictions.rst", category="Predictions"),
        coverage=results("predict/coverage.json"),
    log:
        log_of("predict"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "predict", "diagnosis.folds"),
        seed=seed("predict"),
        code=code("inference.predict_campaign", effects=EFFECTS_ON),
    message:
        "predict: every run, from joint posterior draws"
    shell:
        "eaclutch --log {log} predict --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --output {output.runs:q} --coverage {output.coverage:q}"
