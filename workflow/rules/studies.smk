# Designs and the rest of the paper: maps from the posteriors, the paper's numbers, the finite-element check.


rule sweep:
    input:
        posteriors=expand(results("posterior/{stage}.nc"), stage=STAGES),
        summary=results("posterior/summary.json"),
    output:
        table=results("sweep/maps.csv"),
        page=report(results("sweep/report.html"), caption="../report/sweep.rst", category="Studies"),
    log:
        log_of("sweep"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model", "sweep"),
        code=code("studies.maps", "reporting.map_page", effects=EFFECTS_ON),
    message:
        "sweep: design maps"
    shell:
        "eaclutch --log {log} sweep --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --table {output.table:q} --page {output.page:q}"


rule fea:
    output:
        table=results("fea/pressure.csv"),
        insulators=results("fea/insulators.csv"),
        page=report(results("fea/report.html"), caption="../report/fea.rst", category="Studies"),
    log:
        log_of("fea"),
    params:
        campaign=CAMPAIGN,
        bench=bench("pad"),
        code=code("studies.field_study", "reporting.field_page"),
    message:
        "fea: finite elements against the analytic pressure"
    shell:
        "eaclutch --log {log} fea --campaign {params.campaign:q} --table {output.table:q}"
        " --insulators {output.insulators:q} --page {output.page:q}"


rule paper:
    input:
        runs=results("runs.csv"),
        published=results("runs_published.csv"),
        summary=results("posterior/summary.json"),
    output:
        table=results("paper/numbers.csv"),
        page=report(results("paper/report.html"), caption="../report/paper.rst", category="Studies"),
    log:
        log_of("paper"),
    params:
        campaign=CAMPAIGN,
        results=RESULTS,
        bench=bench(),
        settings=settings("model"),
        code=code("studies.paper", "reporting.paper_page", effects=EFFECTS_ON),
    message:
        "paper: the printed numbers beside ours"
    shell:
        "eaclutch --log {log} paper --campaign {params.campaign:q} --results {params.results:q}"
        " --settings {params.settings:q} --table {output.table:q} --page {output.page:q}"
