"""Workbooks with formulas, entities, links that lead out, and more than memory holds."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path

from openpyxl import Workbook

from hostile_campaigns import sound
from hostile_campaigns.sound import base, case


def _workbook(folder: Path, change: Callable[[zipfile.ZipFile, zipfile.ZipFile], None]) -> None:
    base(folder)
    book = Workbook()
    sheet = book.active
    sheet.title = "w=2mm (1)"
    sheet.append(["Force (N)", "Capacitance (pF)"])
    for i in range(50):
        sheet.append([0.1 * i, 20 + i])
    plain = io.BytesIO()
    book.save(plain)
    with (
        zipfile.ZipFile(plain) as before,
        zipfile.ZipFile(folder / "capacitance" / "book.xlsx", "w", zipfile.ZIP_DEFLATED) as after,
    ):
        change(before, after)


def rewrite_sheet(before: zipfile.ZipFile, after: zipfile.ZipFile, edit: Callable[[bytes], bytes]) -> None:
    for item in before.namelist():
        data = before.read(item)
        after.writestr(item, edit(data) if item.endswith("sheet1.xml") else data)


@case
def workbook_formula_without_value(folder: Path) -> None:
    formula = b'<c r="A3"><f>WEBSERVICE("http://127.0.0.1/")</f></c>'
    _workbook(
        folder,
        lambda b, a: rewrite_sheet(b, a, lambda d: d.replace(b'<c r="A3" t="n"><v>0.1</v></c>', formula)),
    )


@case
def workbook_formula_runs_a_program(folder: Path) -> None:
    formula = b"<c r=\"A3\"><f>cmd|'/c touch canary'!A1</f><v>0.1</v></c>"
    _workbook(
        folder,
        lambda b, a: rewrite_sheet(b, a, lambda d: d.replace(b'<c r="A3" t="n"><v>0.1</v></c>', formula)),
    )


@case
def workbook_laughs(folder: Path) -> None:
    entities = b'<!ENTITY a0 "ha">' + b"".join(
        b'<!ENTITY a%d "%s">' % (i, b"&a%d;" % (i - 1) * 10) for i in range(1, 10)
    )

    def edit(data: bytes) -> bytes:
        head, body = data.split(b"?>", 1) if data.startswith(b"<?xml") else (b'<?xml version="1.0"', data)
        body = body.replace(b"<v>0.1</v>", b"<v>&a9;</v>")
        return head + b"?><!DOCTYPE w [" + entities + b"]>" + body

    _workbook(folder, lambda b, a: rewrite_sheet(b, a, edit))


@case
def workbook_reads_a_file(folder: Path) -> None:
    def edit(data: bytes) -> bytes:
        entity = b'<!DOCTYPE w [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
        return entity + data.replace(b"<v>0.1</v>", b"<v>&x;</v>")

    _workbook(folder, lambda b, a: rewrite_sheet(b, a, edit))


@case
def workbook_external_link(folder: Path) -> None:
    def change(before: zipfile.ZipFile, after: zipfile.ZipFile) -> None:
        rewrite_sheet(before, after, lambda data: data)
        target = b'Target="file:///etc/passwd" TargetMode="External"'
        after.writestr(
            "xl/externalLinks/_rels/externalLink1.xml.rels",
            b'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
            b'<Relationship Id="rId1" '
            b'Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/externalLinkPath" ' + target
            + b"/></Relationships>",
        )  # fmt: skip

    _workbook(folder, change)


@case
def workbook_bomb(folder: Path) -> None:
    def change(before: zipfile.ZipFile, after: zipfile.ZipFile) -> None:
        rewrite_sheet(before, after, lambda data: data)
        with after.open("xl/worksheets/sheet2.xml", "w", force_zip64=True) as stream:
            for _ in range(sound.BOMB_MEGABYTES // 3):
                stream.write(b" " * (1 << 20))

    _workbook(folder, change)


@case
def workbook_endless_rows(folder: Path) -> None:
    def edit(data: bytes) -> bytes:
        row = b'<row r="1048576"><c r="A1048576" t="n"><v>1</v></c></row></sheetData>'
        return data.replace(b"</sheetData>", row)

    _workbook(folder, lambda b, a: rewrite_sheet(b, a, edit))
