#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""orthanc_test.py PROGRAM: round trip to a real archive, over DICOMweb and over DIMSE."""
from __future__ import annotations

import os
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Any

import fixture
from fakes import Proxy
from fixture import ArchiveFixture

SEGMENTATION, STRUCTURES, CAPTURE = "1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.481.3", "1.2.840.10008.5.1.4.1.1.7"


def seed_of(image: Any) -> str:
    """Position in the spleen of the abdomen, or in the middle of the ball."""
    return "0,0,24" if str(image.PatientID) == "ball-7" else "95,-121,-785"


class OrthancTest(ArchiveFixture):
    """Checks that both protocols have the same results."""

    def setUp(self) -> None:
        super().setUp()
        self.server = self.orthanc()

    def addresses(self) -> dict[str, str]:
        return {"DICOMweb": self.server.web, "DIMSE": self.server.dicom}

    def test_round_trip(self) -> None:
        for protocol, address in self.addresses().items():
            with self.subTest(protocol):
                self.round_trip(address)

    def round_trip(self, address: str) -> None:
        import pydicom

        server = ["--server", address]
        before = self.server.instances()
        self.assertEqual(self.json("send", *self.files(), *server), {"stored": len(self.files()), "warnings": []})
        originals = {str(image.SOPInstanceUID): image for image in map(pydicom.dcmread, self.files())}
        first = next(iter(originals.values()))
        if not before:
            self.assertEqual(self.server.instances(), len(originals))

        studies = self.json("find", "--patient-id", str(first.PatientID), "--modality", "CT", *server)["studies"]
        self.assertEqual([study["study"] for study in studies], [str(first.StudyInstanceUID)])
        self.assertEqual(studies[0]["patient_name"], ", ".join(str(first.PatientName).split("^")))
        wanted = str(first.SeriesInstanceUID)
        series = [one for one in self.json("find", studies[0]["study"], *server)["series"] if one["series"] == wanted]
        self.assertEqual([one["instances"] for one in series], [len(originals)])

        fetched = self.json("get", studies[0]["study"], wanted, *server)["series"][0]
        self.assertEqual(fetched["files"], len(originals))
        folder = Path(fetched["folder"])
        self.assertTrue(folder.is_relative_to(self.cache))
        self.assertEqual({file.name for file in folder.iterdir()}, {uid + ".dcm" for uid in originals})
        for file in folder.iterdir():
            image = pydicom.dcmread(file)
            original = originals[str(image.SOPInstanceUID)]
            self.assertEqual(image.file_meta.TransferSyntaxUID, original.file_meta.TransferSyntaxUID)
            self.assertEqual(image.PixelData, original.PixelData)

        made = self.segment(folder, seed_of(first))
        self.assertEqual(self.json("send", *map(str, made), *server)["stored"], 3)
        back = self.folder / ("back-" + address.partition(":")[0].partition("@")[0])
        kinds = set()
        for one in self.json("find", studies[0]["study"], *server)["series"]:
            if one["series"] in {str(pydicom.dcmread(file).SeriesInstanceUID) for file in made}:
                self.json("get", studies[0]["study"], one["series"], "--out", str(back / one["series"]), *server)
                kinds.add(one["modality"])
        self.assertEqual(kinds, {"SEG", "RTSTRUCT", "OT"})
        self.compare_objects(made, sorted(back.rglob("*.dcm")), first, folder)

    def segment(self, folder: Path, seed: str) -> list[Path]:
        """Segmentation, structure set and capture of the same mesh."""
        self.call("segment", str(folder), "labels.nii.gz", "--seed", seed, "--radius", "12", "--name", "spleen", "--save", "scene.json",
                  "--steps", "200", "--backend", "cpu", "--picture", "view.dcm", timeout=300)
        for name in ("seg.dcm", "contours.rtstruct.dcm"):
            self.call("run", "scene.json", "--steps", "0", "--labels", name, "--backend", "cpu")
        return [self.folder / name for name in ("seg.dcm", "contours.rtstruct.dcm", "view.dcm")]

    def compare_objects(self, made: list[Path], back: list[Path], image: Any, folder: Path) -> None:
        """Compares received with sent objects, validates them, and compares the voxels."""
        import nibabel
        import numpy
        import pydicom

        sent = {pydicom.dcmread(file).SOPInstanceUID: pydicom.dcmread(file) for file in made}
        self.assertEqual(len(back), 3)
        classes = set()
        for file in back:
            data = pydicom.dcmread(file)
            classes.add(str(data.SOPClassUID))
            self.assertEqual(data.StudyInstanceUID, image.StudyInstanceUID)
            self.assertEqual(data.PatientID, image.PatientID)
            self.assertNotEqual(data.SeriesInstanceUID, image.SeriesInstanceUID)
            original = sent[data.SOPInstanceUID]
            if "PixelData" in data:
                self.assertEqual(data.PixelData, original.PixelData)
            self.assertEqual(str(data.get("ROIContourSequence", "")), str(original.get("ROIContourSequence", "")))
            if shutil.which("dciodvfy"):
                output = subprocess.run(["dciodvfy", str(file)], capture_output=True, text=True, check=False).stderr
                self.assertNotIn("Error", output, f"{file}: {output}")
            if data.SOPClassUID == SEGMENTATION:
                labels = numpy.asarray(nibabel.load(self.folder / "labels.nii.gz").dataobj) > 0
                places = {float(pydicom.dcmread(one, stop_before_pixels=True).ImagePositionPatient[2]) for one in folder.iterdir()}
                slices = sorted(places)
                frames = numpy.atleast_3d(data.pixel_array).reshape(-1, data.Rows, data.Columns)
                voxels = numpy.zeros_like(labels)
                for frame, item in zip(frames, data.PerFrameFunctionalGroupsSequence):
                    at = slices.index(float(item.PlanePositionSequence[0].ImagePositionPatient[2]))
                    voxels[:, :, at] = frame.T > 0
                self.assertGreater(int(labels.sum()), 100)
                self.assertTrue((voxels == labels).all() or (voxels[:, :, ::-1] == labels).all())
        self.assertEqual(classes, {SEGMENTATION, STRUCTURES, CAPTURE})

    def test_searches(self) -> None:
        import pydicom

        self.call("archive", "send", *self.files(), "--server", self.server.web)
        first = pydicom.dcmread(self.files()[0], stop_before_pixels=True)
        name, day = str(first.PatientName).split("^")[0][1:5], str(first.StudyDate)
        date = f"{day[:4]}-{day[4:6]}-{day[6:]}"
        description = str(first.get("StudyDescription", ""))
        queries = {("--patient-name", name): 1, ("--patient-name", "nobody"): 0, ("--patient-id", str(first.PatientID)): 1,
                 ("--patient-id", "no"): 0, ("--date", date): 1, ("--date", "1900-01-01.." + date): 1,
                 ("--date", date + ".."): 1, ("--date", "1900-01-01..1900-12-31"): 0, ("--modality", "CT"): 1,
                 ("--modality", "US"): 0, ("--description", "no such description"): 0}
        if len(description) > 3:
            queries[("--description", description[1:-1])] = 1
        for protocol, address in self.addresses().items():
            for question, expected in queries.items():
                with self.subTest(f"{protocol} {question}"):
                    found = self.json("find", *question, "--server", address)
                    self.assertEqual(len(found["studies"]), expected)
            self.assertIn("no matching study", self.call("archive", "find", "--patient-id", "no", "--server", address).stdout)
            self.assertIn(str(first.StudyInstanceUID), self.call("archive", "find", "--server", address).stdout)
            unknown = self.call("archive", "find", "1.2.3", "--server", address, status=1).stderr
            self.assertIn("has no such study", unknown)
            unknown = self.call("archive", "get", str(first.StudyInstanceUID), "1.2.3", "--server", address, status=1).stderr
            self.assertIn("has no such series", unknown)
        self.assert_clean()

    def test_the_cache_is_used_and_limited(self) -> None:
        import pydicom

        self.call("archive", "send", *self.files(), "--server", self.server.web)
        first = pydicom.dcmread(self.files()[0], stop_before_pixels=True)
        what = [str(first.StudyInstanceUID), str(first.SeriesInstanceUID)]
        for address in self.addresses().values():
            folder = Path(self.call("archive", "get", *what, "--server", address).stdout.strip())
            marked = next(folder.iterdir())
            os.utime(marked, (1, 1))  # a file that is fetched again gets a new time
            self.call("archive", "get", *what, "--server", address)
            self.assertEqual(marked.stat().st_mtime, 1)
            marked.unlink()  # an incomplete series is fetched again
            self.call("archive", "get", *what, "--server", address)
            self.assertEqual(len(list(folder.iterdir())), len(self.files()))
        folders = [path for path in self.cached() if path.is_dir()]
        self.assertEqual(len(folders), 2)
        self.assertEqual(self.cache.stat().st_mode & 0o777, 0o700)
        too_large = self.call("archive", "get", *what, "--server", self.server.web, "--cache", "small", "--cache-limit", "0.001",
                              status=1).stderr
        self.assertIn("larger than 1.0 MB", too_large)
        self.assertEqual(list((self.folder / "small").rglob("*.dcm")), [])

    def test_servers_have_names(self) -> None:
        self.assertIn("no archive", self.call("archive", "servers", "list").stdout)
        self.assertIn("none is selected", self.call("archive", "find", status=2).stderr)
        self.call("archive", "servers", "add", "web", self.server.web)
        self.call("archive", "servers", "add", "classic", self.server.dicom, "--calling-title", "TESTER")
        listed = self.call("archive", "servers", "list").stdout
        self.assertIn(self.server.web, listed)
        self.assertIn(self.server.dicom, listed)
        for name in ("web", "classic"):
            self.assertIn("is reachable", self.call("archive", "servers", "check", name).stdout)
        unknown = self.call("archive", "servers", "check", "another", status=2).stderr
        self.assertIn("choose one of: web, classic", unknown)
        self.call("archive", "servers", "remove", "classic")
        self.assertEqual(self.json("find")["studies"], [])  # without --server the only one is used
        self.server.stop()
        for address in self.addresses().values():
            self.assertIn("refused the connection", self.call("archive", "servers", "check", address, status=1).stderr)


    def test_titles(self) -> None:
        strict = self.orthanc(DicomCheckCalledAet=True)
        message = self.call("archive", "find", "--server", strict.dicom.replace("ORTHANC", "WRONG"), status=1).stderr
        self.assertIn("rejected the AE title WRONG", message)
        self.assertEqual(self.json("find", "--server", strict.dicom)["studies"], [])


class SecureTest(ArchiveFixture):
    """TLS with a self-signed certificate, and users with passwords. Debian's Orthanc crashes with TLS enabled, so a proxy
    handles TLS, as it does for many archives."""

    def setUp(self) -> None:
        super().setUp()
        self.certificate = self.make_certificate("right", f"IP:{fixture.LOCAL}")
        self.other = self.make_certificate("other", "DNS:elsewhere.example")

    def make_certificate(self, name: str, holder: str) -> Path:
        """Makes a certificate for 127.0.0.1 or another host, in one file with its key."""
        key, certificate, both = (self.folder / f"{name}{ending}" for ending in (".key", ".crt", ".pem"))
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", str(key), "-out", str(certificate),
                        "-days", "2", "-subj", f"/CN={name}", "-addext", f"subjectAltName={holder}"], check=True, capture_output=True)
        both.write_bytes(key.read_bytes() + certificate.read_bytes())
        return certificate

    def secure(self, certificate: Path, **settings: Any) -> str:
        """URL of an Orthanc behind TLS."""
        proxy = Proxy(self.orthanc(**settings).web_port, certificate=str(certificate.with_suffix(".pem")))
        self.addCleanup(proxy.stop)
        return f"https://{fixture.LOCAL}:{proxy.port}/dicom-web"

    def test_a_certificate_is_rejected_until_its_issuer_is_trusted(self) -> None:
        server = self.secure(self.certificate)
        message = self.call("archive", "find", "--server", server, status=1).stderr
        self.assertIn("certificate is not trusted", message)
        self.call("archive", "send", *self.files(), "--server", server, "--ca-file", str(self.certificate))
        found = self.json("find", "--server", server, "--ca-file", str(self.certificate))
        self.assertEqual(len(found["studies"]), 1)
        self.call("archive", "servers", "add", "secure", server, "--ca-file", str(self.certificate))
        self.assertEqual(len(self.json("find", "--server", "secure")["studies"]), 1)
        message = self.call("archive", "find", "--server", server, "--ca-file", str(self.other), status=1).stderr
        self.assertIn("certificate is not trusted", message)
        message = self.call("archive", "find", "--server", server, "--ca-file", "nothing.pem", status=1).stderr
        self.assertIn("cannot be read", message)

    def test_a_certificate_of_another_host_is_rejected(self) -> None:
        server = self.secure(self.other)
        message = self.call("archive", "find", "--server", server, "--ca-file", str(self.other), status=1).stderr
        self.assertIn("certificate is not trusted", message)

    def test_credentials(self) -> None:
        secret = "correct-horse-7"
        server = self.secure(self.certificate, AuthenticationEnabled=True, RegisteredUsers={"ann": secret})
        where = ["--server", server, "--ca-file", str(self.certificate)]
        self.assertIn("requires credentials (401)", self.call("archive", "find", *where, status=1).stderr)
        variable = ["--credentials-variable", "ARCHIVE_LOGIN"]
        self.assertIn("not set", self.call("archive", "find", *where, *variable, status=2).stderr)
        right, wrong = {"ARCHIVE_LOGIN": f"ann:{secret}"}, {"ARCHIVE_LOGIN": f"ann:{secret}-no"}
        self.call("archive", "find", *where, *variable, environment=right)
        message = self.call("archive", "find", *where, *variable, environment=wrong, status=1).stderr
        self.assertIn("rejected the credentials (401)", message)
        self.assertNotIn(secret, message)
        message = self.call("archive", "find", *where, *variable, environment={"ARCHIVE_LOGIN": secret}, status=2).stderr
        self.assertNotIn(secret, message)

        file = self.folder / "login"
        file.write_text(f"ann:{secret}\n")
        file.chmod(0o644)
        message = self.call("archive", "find", *where, "--credentials-file", str(file), status=2).stderr
        self.assertIn("chmod 600", message)
        self.assertNotIn(secret, message)
        file.chmod(0o600)
        self.call("archive", "servers", "add", "ours", server, "--ca-file", str(self.certificate), "--credentials-file", "login")
        self.call("archive", "send", *self.files(), "--server", "ours")
        self.assertEqual(len(self.json("find", "--server", "ours")["studies"]), 1)
        for kept in (self.folder / "config").rglob("*"):
            self.assertFalse(kept.is_file() and secret in kept.read_text())
        message = self.call("archive", "servers", "add", "bad", f"https://ann:{secret}@{fixture.LOCAL}/x", status=2).stderr
        self.assertIn("contains a user or a password", message)
        self.assertNotIn(secret, message)
        self.assertIn("unencrypted", self.call("archive", "servers", "add", "bad", "http://archive.example/x", "--credentials-file",
                                               "login", status=2).stderr)


if __name__ == "__main__":
    fixture.main((fixture.ORTHANC, "orthanc"), (fixture.DICOM_WEB, "orthanc-dicomweb"), ("openssl", "openssl"),
                 ("pydicom", "python3-pydicom"), ("nibabel", "python3-nibabel"))
