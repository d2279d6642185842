# What there is: recordings from a folder, the live rig or the simulated rig; every file with its checksum.


checkpoint capture:
    input:
        plan=CONFIG["capture"]["plan"] or [],
        facts=f"{CAMPAIGN}/campaign.yaml",
        files=[
            file
            for folder in ("tensile", "capacitance", "permittivity", "load_cell")
            for file in campaign_files(folder)
        ],
    output:
        results("capture.json"),
    log:
        log_of("capture"),
    params:
        campaign=CAMPAIGN,
        settings=settings("capture", "observables.batch_size"),
        seed=seed("capture"),
        code=code("manifest", "rig.campaign"),
    message:
        "capture: list and check the recordings"
    shell:
        "eaclutch --log {log} capture --campaign {params.campaign:q} --settings {params.settings:q}"
        " --seed {params.seed} --output {output:q}"
