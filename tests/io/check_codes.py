# SPDX-License-Identifier: Apache-2.0
"""Compares the codes of label presets with the context groups of DICOM, as pydicom has them.

check_codes.py PRESET.json...
Fails for a code that no context group contains and that is not in ELSEWHERE, or whose meaning differs.
"""
import json
import sys

from pydicom.sr._concepts_dict import concepts

# Codes that no context group of this version of pydicom contains, from the mapping of TotalSegmentator
# (totalsegmentator/resources/totalsegmentator_snomed_mapping.csv), which gives codes for DICOM segmentations.
ELSEWHERE = {
    "39976000": "C2 vertebra", "113205007": "C3 vertebra", "5329002": "C4 vertebra", "36978003": "C5 vertebra",
    "36054005": "C6 vertebra", "87391001": "C7 vertebra", "64864005": "T1 vertebra", "53733008": "T2 vertebra",
    "1626008": "T3 vertebra", "73071006": "T4 vertebra", "56401006": "T5 vertebra", "45296009": "T6 vertebra",
    "62487009": "T7 vertebra", "11068009": "T8 vertebra", "82687006": "T9 vertebra", "7610001": "T10 vertebra",
    "12989004": "T11 vertebra", "23215003": "T12 vertebra", "66794005": "L1 vertebra", "14293000": "L2 vertebra",
    "36470004": "L3 vertebra", "11994002": "L4 vertebra", "49668003": "L5 vertebra", "74281007": "Myocardium",
    "110765007": "Portal vein and splenic vein", "68455001": "Iliopsoas muscle",
}  # fmt: skip


def known_meanings():
    """Meanings of each SNOMED CT code in the context groups, and the numbers of these groups."""
    meanings = {}
    for codes in concepts["SCT"].values():
        for code, (meaning, groups) in codes.items():
            meanings.setdefault(code, set()).add((meaning.lower(), tuple(groups)))
    return meanings


def main():
    known = known_meanings()
    faults = []
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as file:
            labels = json.load(file)["labels"]
        for label in labels:
            for part, group in (("category", 7150), ("type", None), ("modifier", 244)):
                if part not in label:
                    continue
                code, meaning = label[part]["code"], label[part]["meaning"]
                found = {m for m, groups in known.get(code, ()) if groups and (group is None or group in groups)}
                if code in ELSEWHERE:
                    found.add(ELSEWHERE[code].lower())
                if meaning.lower() not in found:
                    faults.append(f"{path}: {label['name']}: {part} {code} is {found or 'unknown'}, not '{meaning}'")
    print("\n".join(faults))
    return bool(faults)


sys.exit(main())
