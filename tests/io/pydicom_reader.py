# SPDX-License-Identifier: Apache-2.0
"""Reads a segmentation or structure set with pydicom, for tests. Prints a line for each segment or region: its name, colour
(regions), codes and the number of voxels on each slice of the images. Slices are matched by the referenced instances.

pydicom_reader.py FILE IMAGE...
The bits are unpacked and the polygons are filled here, by the even-odd rule at the pixel centres.
"""
import sys

import pydicom


def pixel_counts(contours, images):
    """Number of voxels inside the polygons of each image."""
    counts = dict.fromkeys(images, 0)
    for uid, image in images.items():
        at = [float(v) for v in image.ImagePositionPatient]
        axes = [float(v) for v in image.ImageOrientationPatient]
        row_mm, column_mm = (float(v) for v in image.PixelSpacing)
        polygons = []
        for contour in contours:
            if contour.ContourImageSequence[0].ReferencedSOPInstanceUID != uid:
                continue
            assert contour.ContourGeometricType == "CLOSED_PLANAR"
            data = [float(v) for v in contour.ContourData]
            assert len(data) == 3 * int(contour.NumberOfContourPoints)
            polygon = []
            for p in range(0, len(data), 3):
                offset = [data[p + a] - at[a] for a in range(3)]
                i = sum(w * a for w, a in zip(offset, axes[:3])) / column_mm
                j = sum(w * a for w, a in zip(offset, axes[3:])) / row_mm
                rest = [offset[a] - i * column_mm * axes[a] - j * row_mm * axes[3 + a] for a in range(3)]
                assert max(abs(r) for r in rest) < 1e-3, "the contour is not in the plane of its slice"
                polygon.append((i, j))
            polygons.append(polygon)
        inside = set()
        for polygon in polygons:
            for j in range(image.Rows):
                crossings = sorted(
                    a[0] + (j - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
                    for a, b in zip(polygon, polygon[1:] + polygon[:1])
                    if (a[1] > j) != (b[1] > j)
                )
                for low, high in zip(crossings[::2], crossings[1::2]):
                    inside.update((i, j) for i in range(image.Columns) if low < i <= high)
        counts[uid] = len(inside)
    return counts


def codes_of(item, kind):
    """Codes of the category in an item, of its type and of the modifier of the type."""
    category = item.SegmentedPropertyCategoryCodeSequence[0]
    texts = [f"{category.CodingSchemeDesignator} {category.CodeValue}"]
    for code in [kind, *kind.get("SegmentedPropertyTypeModifierCodeSequence", [])]:
        texts.append(f"{code.CodingSchemeDesignator} {code.CodeValue} {code.CodeMeaning}")
    return ", ".join(texts)


def main():
    data = pydicom.dcmread(sys.argv[1])
    images = {}
    for path in sys.argv[2:]:
        image = pydicom.dcmread(path)
        images[image.SOPInstanceUID] = image
    order = sorted(images, key=lambda uid: int(images[uid].InstanceNumber))
    first = images[order[0]]
    assert data.StudyInstanceUID == first.StudyInstanceUID and data.SeriesInstanceUID != first.SeriesInstanceUID
    assert data.FrameOfReferenceUID == first.FrameOfReferenceUID
    assert data.PatientName == first.PatientName and data.PatientID == first.PatientID
    if data.Modality == "SEG":
        plane = data.Rows * data.Columns
        for segment in data.SegmentSequence:
            assert segment.SegmentAlgorithmType == "SEMIAUTOMATIC" and segment.SegmentAlgorithmName
            voxels = dict.fromkeys(order, 0)
            for f, frame in enumerate(data.PerFrameFunctionalGroupsSequence):
                source = frame.DerivationImageSequence[0].SourceImageSequence[0].ReferencedSOPInstanceUID
                place = [float(v) for v in frame.PlanePositionSequence[0].ImagePositionPatient]
                there = [float(v) for v in images[source].ImagePositionPatient]
                assert max(abs(a - b) for a, b in zip(place, there)) < 1e-6, "a frame is not at the position of its image"
                if frame.SegmentIdentificationSequence[0].ReferencedSegmentNumber != segment.SegmentNumber:
                    continue
                for bit in range(f * plane, (f + 1) * plane):
                    voxels[source] += data.PixelData[bit // 8] >> (bit % 8) & 1
            code = codes_of(segment, segment.SegmentedPropertyTypeCodeSequence[0])
            print(segment.SegmentLabel, code, *(voxels[uid] for uid in order), sep="|")
    else:
        regions = {int(r.ROINumber): r for r in data.StructureSetROISequence}
        observations = {int(o.ReferencedROINumber): o for o in data.RTROIObservationsSequence}
        for contours in data.ROIContourSequence:
            counts = pixel_counts(contours.get("ContourSequence", []), images)
            colour = "/".join(str(c) for c in contours.ROIDisplayColor)
            number = int(contours.ReferencedROINumber)
            code = codes_of(observations[number], observations[number].RTROIIdentificationCodeSequence[0])
            print(regions[number].ROIName, colour, code, *(counts[u] for u in order), sep="|")


main()
