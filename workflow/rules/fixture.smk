# The campaigns of data/: made by the simulator from their recipes, so that anybody can make them again.


rule fixture:
    input:
        CHECKOUT / "data" / "{fixture}.yaml",
    output:
        directory("data/{fixture}"),
    log:
        "data/logs/{fixture}.log",
    params:
        code=code("simulation.campaign", "simulation.recipe"),
    wildcard_constraints:
        fixture="fixture|fixture-null",
    message:
        "fixture: simulate {wildcards.fixture}"
    shell:
        "eaclutch --log {log} simulate --recipe {input:q} --output {output:q} --replace"
