# What there is: recordings from a folder, from the live rig or from the simulated rig; every file with its checksum.


def folder_state():
    """Names, sizes and times of the campaign's files: a change lists and checks them anew."""
    files = [
        (str(path.relative_to(CAMPAIGN)), path.stat().st_size, path.stat().st_mtime_ns)
        for folder in (".", "tensile", "capacitance", "permittivity", "load_cell")
        for path in sorted(Path(CAMPAIGN, folder).glob("*"))
        if path.is_file()
    ]
    return hashlib.sha256(repr(files).encode()).hexdigest()[:16]


checkpoint capture:
    input:
        CONFIG["capture"]["plan"] or [],
    output:
        results("capture.json"),
    log:
        log_of("capture"),
    params:
        campaign=CAMPAIGN,
        settings=settings("capture", "observables.batch_size"),
        seed=seed("capture"),
        state=folder_state(),
        code=code("rig.campaign", "manifest"),
    message:
        "capture: list and check the recordings"
    shell:
        "eaclutch --log {log} capture-check --campaign {params.campaign:q} --settings {params.settings:q}"
        " --seed {params.seed} --output {output:q}"


def captured():
    """capture.json once it is there."""
    return json.loads(Path(checkpoints.capture.get().output[0]).read_text(encoding="utf-8"))


def capture_file(*_):
    """Input of all that reads recordings: a job waits for it, and reruns by the checksums it names, not by its age."""
    return ancient(checkpoints.capture.get().output[0])


def content(*folders, runs=None):
    """Hash of the content of the campaign's files in these folders (of the named runs only, where given)."""
    listing = json.loads(Path(results("capture.json")).read_text(encoding="utf-8"))
    wanted = {entry["path"] for entry in listing["runs"] if runs is not None and entry["run"] in runs}
    wanted |= {entry["path"] for entry in listing["files"] if entry["path"].split("/")[0] in folders}
    chosen = sorted((entry["path"], entry["sha256"]) for entry in listing["files"] if entry["path"] in wanted)
    return hashlib.sha256(repr(chosen).encode()).hexdigest()[:16]
