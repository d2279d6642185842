# What there is: recordings from a folder, from the live rig or from the simulated rig; every file with its checksum.
ADD_RUNS = (
    ""
    if CONFIG["capture"]["source"] == "recordings"
    else "eaclutch --log {log} capture {params.campaign:q} --settings {params.settings:q} --seed {params.seed} && "
)


checkpoint capture:
    input:
        plan=CONFIG["capture"]["plan"] or [],
        facts=f"{CAMPAIGN}/campaign.yaml",
        files=[
            file for folder in ("tensile", "capacitance", "permittivity", "load_cell") for file in campaign_files(folder)
        ],
    output:
        results("capture.json"),
    log:
        log_of("capture"),
    params:
        campaign=CAMPAIGN,
        settings=settings("capture"),
        batch_size=CONFIG["observables"]["batch_size"],
        seed=seed("capture"),
        code=code("rig.campaign", "manifest"),
    message:
        "capture: list and check the recordings"
    shell:
        ADD_RUNS + "eaclutch --log {log} check {params.campaign:q} --batch-size {params.batch_size} --out {output:q}"
