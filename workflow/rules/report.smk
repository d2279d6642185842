# What people read, and what lets them check it.


rule report:
    input:
        capture=results("capture.json"),
        runs=results("runs.csv"),
        definitions=results("observables.json"),
        quality=results("quality.json"),
        published=results("runs_published.csv"),
        gap=results("gap.csv"),
        bursts=results("bursts.csv"),
        spectra=results("spectra.csv"),
        traces=all_batches("observables/traces_{batch}.npz"),
        posteriors=expand(results("posterior/{stage}.nc"), stage=STAGES),
        summary=results("posterior/summary.json"),
        predictions=results("predict/runs.csv"),
        coverage=results("predict/coverage.json"),
        diagnosis=results("diagnosis/diagnosis.json"),
    output:
        report(results("report.html"), caption="../report/report.rst", category="Diagnosis"),
    log:
        log_of("report"),
    params:
        results=RESULTS,
        config=json.dumps(CONFIG, sort_keys=True),
        bench=bench(),
        code=code("reporting.page", "reporting.results"),
    message:
        "report: one page"
    shell:
        "eaclutch --log {log} report --results {params.results:q} --settings {params.config:q} --output {output:q}"


rule manifest:
    input:
        rules.report.input,
        report=results("report.html"),
    output:
        results("manifest.json"),
    log:
        log_of("manifest"),
    params:
        results=RESULTS,
        config=json.dumps(CONFIG, sort_keys=True),
        code=code("manifest"),
    message:
        "manifest: checksums of inputs and results"
    shell:
        "eaclutch --log {log} manifest --results {params.results:q} --settings {params.config:q} --output {output:q}"
