# What the calibrated model says of every run, on draws and on left-out conditions: a job some thousand runs, then one table.


def prediction_jobs():
    """How many jobs the captured runs are shared among."""
    return max(1, -(-len(captured()["runs"]) // CONFIG["predict"]["runs_per_job"]))


rule predict:
    input:
        capture=capture_file,  # a job elsewhere counts the captured runs itself
        runs=results("runs.csv"),
        draws=expand(results("posterior/{stage}.nc"), stage=STAGES),
        summary=results("posterior/summary.json"),
    output:
        results("predict/batch_{batch}.csv"),
    log:
        log_of("predict", "batch_{batch}"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "priors", "predict.draws", "predict.folds"),
        seed=seed("predict"),
        jobs=lambda wildcards: prediction_jobs(),
        code=code("inference.predict_campaign", effects=EFFECTS_ON),
    message:
        "predict: batch {wildcards.batch}, from joint posterior draws"
    shell:
        "eaclutch --log {log} predict --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --seed {params.seed} --job {wildcards.batch} --jobs {params.jobs}"
        " --output {output:q}"


rule predictions:
    input:
        lambda wildcards: [results(f"predict/batch_{batch}.csv") for batch in range(prediction_jobs())],
    output:
        runs=report(results("predict/runs.csv"), caption="../report/predictions.rst", category="Predictions"),
        coverage=results("predict/coverage.json"),
    log:
        log_of("predictions"),
    params:
        code=code("inference.predict_campaign"),
    message:
        "predictions: one table of all runs, and their calibration curves"
    shell:
        "eaclutch --log {log} predictions --output {output.runs:q} --coverage {output.coverage:q} {input:q}"
