# SPDX-License-Identifier: Apache-2.0
"""Compares documents of one segmentation with pydicom, for tests: a binary segmentation and a label map of equal pixels, and a
structured report that refers to the first. Prints a line for each measurement group of the report.

pydicom_documents.py SEGMENTATION LABEL_MAP REPORT
"""
import struct
import sys

import pydicom


def place_of(frame):
    return tuple(float(v) for v in frame.PlanePositionSequence[0].ImagePositionPatient)


def planes_of_bits(data):
    """Segment numbers by position and pixel, from bit planes."""
    count = data.Rows * data.Columns
    planes = {}
    for f, frame in enumerate(data.PerFrameFunctionalGroupsSequence):
        segment = frame.SegmentIdentificationSequence[0].ReferencedSegmentNumber
        plane = planes.setdefault(place_of(frame), [0] * count)
        for p in range(count):
            bit = f * count + p
            if data.PixelData[bit // 8] >> (bit % 8) & 1:
                plane[p] = segment
    return planes


def planes_of_labels(data):
    """Pixel values by position."""
    count = data.Rows * data.Columns
    code = "B" if data.BitsAllocated == 8 else "H"
    values = struct.unpack_from(f"<{count * int(data.NumberOfFrames)}{code}", data.PixelData)
    frames = data.PerFrameFunctionalGroupsSequence
    return {place_of(frame): list(values[f * count : (f + 1) * count]) for f, frame in enumerate(frames)}


def check_label_map(binary, label_map):
    assert label_map.SOPClassUID == "1.2.840.10008.5.1.4.1.1.66.7" and label_map.SegmentationType == "LABELMAP"
    assert label_map.BitsStored == label_map.BitsAllocated and label_map.HighBit == label_map.BitsAllocated - 1
    assert label_map.SamplesPerPixel == 1 and label_map.PixelRepresentation == 0
    assert label_map.PhotometricInterpretation == "MONOCHROME2" and label_map.SegmentsOverlap == "NO"
    assert label_map.PixelPaddingValue == 0
    assert label_map[0x7FE00010].VR == ("OB" if label_map.BitsAllocated == 8 else "OW")
    for frame in label_map.PerFrameFunctionalGroupsSequence:
        assert "SegmentIdentificationSequence" not in frame
    background, *described = label_map.SegmentSequence
    assert background.SegmentNumber == 0 and background.SegmentedPropertyTypeCodeSequence[0].CodeValue == "125040"
    assert [s.SegmentLabel for s in described] == [s.SegmentLabel for s in binary.SegmentSequence]
    # Equal pixels: segments of the bit planes are numbered in the order of the labels.
    numbers = [0] + [s.SegmentNumber for s in described]
    bits, labels = planes_of_bits(binary), planes_of_labels(label_map)
    assert bits.keys() == labels.keys()
    for place, plane in bits.items():
        assert [numbers[segment] for segment in plane] == labels[place], "the pixels differ"


def items(container, meaning):
    return [i for i in container.ContentSequence if i.ConceptNameCodeSequence[0].CodeMeaning == meaning]


def number(item):
    value = item.MeasuredValueSequence[0]
    return f"{float(value.NumericValue):.6g} {value.MeasurementUnitsCodeSequence[0].CodeValue}"


def print_report(binary, report):
    assert report.SOPClassUID == "1.2.840.10008.5.1.4.1.1.88.34" and report.Modality == "SR"
    assert report.StudyInstanceUID == binary.StudyInstanceUID and report.PatientName == binary.PatientName
    assert report.SeriesInstanceUID != binary.SeriesInstanceUID and report.SOPInstanceUID != binary.SOPInstanceUID
    template = report.ContentTemplateSequence[0]
    assert template.MappingResource == "DCMR" and template.TemplateIdentifier == "1500"
    images = {i.ReferencedSOPInstanceUID for i in binary.ReferencedSeriesSequence[0].ReferencedInstanceSequence}
    study = report.CurrentRequestedProcedureEvidenceSequence[0]
    assert study.StudyInstanceUID == binary.StudyInstanceUID
    evidence = {s.SeriesInstanceUID: {i.ReferencedSOPInstanceUID for i in s.ReferencedSOPSequence} for s in study.ReferencedSeriesSequence}
    source = binary.ReferencedSeriesSequence[0].SeriesInstanceUID
    assert evidence == {binary.SeriesInstanceUID: {binary.SOPInstanceUID}, source: images}
    segments = {s.SegmentNumber: s for s in binary.SegmentSequence}
    for group in items(items(report, "Imaging Measurements")[0], "Measurement Group"):
        reference = items(group, "Referenced Segment")[0].ReferencedSOPSequence[0]
        assert reference.ReferencedSOPInstanceUID == binary.SOPInstanceUID
        assert reference.ReferencedSOPClassUID == binary.SOPClassUID
        segment = segments.pop(reference.ReferencedSegmentNumber)
        assert items(group, "Tracking Unique Identifier")[0].UID == segment.TrackingUID
        assert items(group, "Tracking Identifier")[0].TextValue == segment.TrackingID == segment.SegmentLabel
        assert items(group, "Source series for segmentation")[0].UID == source
        finding = items(group, "Finding")[0].ConceptCodeSequence[0]
        assert finding.CodeValue == segment.SegmentedPropertyTypeCodeSequence[0].CodeValue
        texts = [f"{reference.ReferencedSegmentNumber}", segment.SegmentLabel, finding.CodeMeaning]
        for site in items(group, "Finding Site"):
            sides = [c.ConceptCodeSequence[0].CodeMeaning for c in site.get("ContentSequence", [])]
            texts.append("site " + " ".join([site.ConceptCodeSequence[0].CodeMeaning, *sides]))
        for item in group.ContentSequence:
            if item.ValueType != "NUM":
                continue
            name = item.ConceptNameCodeSequence[0].CodeMeaning
            derivations = [c.ConceptCodeSequence[0].CodeMeaning for c in item.get("ContentSequence", [])]
            texts.append(" ".join([name, *derivations, number(item)]))
        print(*texts, sep="|")
    assert not segments, "a segment has no measurements"


binary, label_map, report = (pydicom.dcmread(path) for path in sys.argv[1:])
check_label_map(binary, label_map)
print_report(binary, report)
