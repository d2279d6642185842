"""A campaign.yaml that carries code, grows without end, or states what cannot be."""

from __future__ import annotations

from pathlib import Path

from hostile_campaigns.sound import NAME, base, case


@case
def yaml_python_tag(folder: Path) -> None:
    base(folder, 'name: !!python/object/apply:os.system ["touch canary"]\n')


@case
def yaml_aliases(folder: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 12)]
    base(folder, "\n".join(lines) + "\n")


@case
def yaml_deep(folder: Path) -> None:
    base(folder, "name: " + "[" * 100_000 + "]" * 100_000 + "\n")


@case
def yaml_runs_python_in_configs(folder: Path) -> None:
    base(folder, "__use_yte__: true\n__definitions__:\n  - import os; os.system('touch canary')\n")


@case
def yaml_name_leads_elsewhere(folder: Path) -> None:
    base(folder, "name: ../../elsewhere\n")


@case
def yaml_not_finite(folder: Path) -> None:
    base(folder, "film: {density_kg_m3: .inf}\nfriction: {film: {static: [.nan, 1.0]}}\n")


@case
def yaml_absurd_numbers(folder: Path) -> None:
    base(folder, "pad: {electrodes: 999999999999999999999999}\n")


@case
def yaml_reason_with_html(folder: Path) -> None:
    base(folder, f"exclude: {{'../../{NAME}': '<script>alert(1)</script>'}}\n")
