# SPDX-License-Identifier: Apache-2.0
"""Fixture for tests of archives: an Orthanc on the loopback, a series, and calls of the program.

The tests use no address other than 127.0.0.1, and every server ends with its test."""
from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from with_program import main, program, skip  # noqa: E402

ORTHANC = "/usr/sbin/Orthanc"
DICOM_WEB = "/usr/share/orthanc/plugins/libOrthancDicomWeb.so"
LOCAL = "127.0.0.1"


def free_port() -> int:
    """Unused port of the loopback."""
    with socket.socket() as probe:
        probe.bind((LOCAL, 0))
        return int(probe.getsockname()[1])


class Orthanc:
    """Debian's Orthanc with separate storage and settings."""

    def __init__(self, folder: Path, settings: dict[str, Any] | None = None) -> None:
        self.web_port, self.dicom_port = free_port(), free_port()
        self.folder = folder / f"orthanc-{self.web_port}"
        self.folder.mkdir()
        config: dict[str, Any] = {
            "Name": "Test", "StorageDirectory": str(self.folder / "store"), "IndexDirectory": str(self.folder / "store"),
            "Plugins": [DICOM_WEB], "DicomWeb": {"Enable": True, "Root": "/dicom-web/"}, "HttpPort": self.web_port,
            "DicomPort": self.dicom_port, "DicomAet": "ORTHANC", "DicomAlwaysAllowFind": True, "DicomAlwaysAllowGet": True,
            "DicomAlwaysAllowStore": True, "RemoteAccessAllowed": False, "AuthenticationEnabled": False,
            "HttpThreadsCount": 4, "SyncStorageArea": False, "OverwriteInstances": True}
        config.update(settings or {})
        file = self.folder / "orthanc.json"
        file.write_text(json.dumps(config), encoding="utf-8")
        with open(self.folder / "log", "w", encoding="utf-8") as log:
            self.process = subprocess.Popen([ORTHANC, str(file)], stdout=log, stderr=log)
        deadline = time.monotonic() + 60
        while not (self.listens(self.web_port) and self.listens(self.dicom_port)):
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("Orthanc does not start: " + (self.folder / "log").read_text()[-2000:])
            time.sleep(0.1)

    @staticmethod
    def listens(port: int) -> bool:
        """Whether a port accepts connections."""
        with socket.socket() as probe:
            return probe.connect_ex((LOCAL, port)) == 0

    @property
    def web(self) -> str:
        """URL for DICOMweb."""
        return f"http://{LOCAL}:{self.web_port}/dicom-web"

    @property
    def dicom(self) -> str:
        """Address for DIMSE."""
        return f"ORTHANC@{LOCAL}:{self.dicom_port}"

    def rest(self, path: str) -> Any:
        """Response of Orthanc's REST interface."""
        with urllib.request.urlopen(f"http://{LOCAL}:{self.web_port}{path}", timeout=20) as response:
            return json.loads(response.read())

    def instances(self) -> int:
        """Number of stored instances."""
        return int(self.rest("/statistics")["CountInstances"])

    def kill(self) -> None:
        """Kills Orthanc."""
        self.process.send_signal(signal.SIGKILL)

    def stop(self) -> None:
        """Stops Orthanc."""
        self.process.kill()
        self.process.wait(30)


def data_folder(name: str) -> Path | None:
    """Folder of test data, if there is any."""
    for root in os.environ.get("SIMPLEXSEG_DATA", "").split(":"):
        if root and (Path(root) / name).is_dir():
            return Path(root) / name
    return None


def make_series(folder: Path, slices: int = 12, size: int = 48) -> None:
    """Writes a bright ball in 2 mm voxels as a CT series."""
    import numpy
    import pydicom
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian

    folder.mkdir()
    j, i = numpy.mgrid[:size, :size]
    for k in range(slices):
        radius = numpy.sqrt((i - size / 2) ** 2 + (j - size / 2) ** 2 + (2.0 * (k - slices / 2)) ** 2)
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID, meta.TransferSyntaxUID = CTImageStorage, ExplicitVRLittleEndian
        meta.MediaStorageSOPInstanceUID = f"1.2.826.0.1.3680043.9.7.1.{k + 1}"
        image = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        image.is_little_endian, image.is_implicit_VR = True, False
        image.SpecificCharacterSet, image.ImageType = "ISO_IR 192", ["ORIGINAL", "PRIMARY", "AXIAL"]
        image.SOPClassUID, image.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        image.StudyDate, image.StudyTime, image.Modality, image.Manufacturer = "20240531", "101500", "CT", "none"
        image.AccessionNumber, image.ReferringPhysicianName, image.StudyID = "", "", "1"
        image.StudyDescription, image.SeriesDescription = "Ball of the test", "2 mm"
        image.PatientName, image.PatientID = "Müller^Ball", "ball-7"
        image.PatientBirthDate, image.PatientSex, image.PositionReferenceIndicator = "", "", ""
        image.StudyInstanceUID, image.SeriesInstanceUID = "1.2.826.0.1.3680043.9.7.2", "1.2.826.0.1.3680043.9.7.3"
        image.FrameOfReferenceUID = "1.2.826.0.1.3680043.9.7.4"
        image.SeriesNumber, image.InstanceNumber, image.AcquisitionNumber, image.KVP = 1, k + 1, 1, "120"
        image.ImagePositionPatient, image.ImageOrientationPatient = [-size, -size, 4.0 * k], [1, 0, 0, 0, 1, 0]
        image.PixelSpacing, image.SliceThickness, image.PatientPosition = [2, 2], 4, "HFS"
        image.SamplesPerPixel, image.PhotometricInterpretation = 1, "MONOCHROME2"
        image.Rows, image.Columns, image.BitsAllocated, image.BitsStored, image.HighBit = size, size, 16, 12, 11
        image.PixelRepresentation, image.RescaleIntercept, image.RescaleSlope, image.RescaleType = 0, -1024, 1, "HU"
        image.PixelData = numpy.where(radius < 12, 1124, 924).astype("<u2").tobytes()
        pydicom.dcmwrite(folder / f"{k}.dcm", image, write_like_original=False)


def name_series(source: Path, folder: Path) -> None:
    """Copy of an anonymous series with invented patient data, which an archive requires."""
    import pydicom

    folder.mkdir()
    for file in source.iterdir():
        image = pydicom.dcmread(file)
        image.SOPClassUID, image.SOPInstanceUID = image.file_meta.MediaStorageSOPClassUID, image.file_meta.MediaStorageSOPInstanceUID
        image.StudyInstanceUID, image.SeriesInstanceUID = "1.2.826.0.1.3680043.9.7.5", "1.2.826.0.1.3680043.9.7.6"
        image.PatientName, image.PatientID, image.StudyDescription = "Abdomen^Of The Test", "abdomen-1", "Abdomen"
        pydicom.dcmwrite(folder / file.name, image)


class ArchiveFixture(unittest.TestCase):
    """Test with a temporary folder, which also contains settings and cache of the program."""

    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory(prefix="simplexseg-archive-")
        self.folder = Path(self.temporary.name)
        self.cache = self.folder / "cache" / "simplexseg" / "archive"
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config"),
                            "XDG_CACHE_HOME": str(self.folder / "cache"), "NO_PROXY": "*"}
        self.addCleanup(self.temporary.cleanup)

    def orthanc(self, **settings: Any) -> Orthanc:
        """Orthanc that ends with the test."""
        server = Orthanc(self.folder, settings)
        self.addCleanup(server.stop)
        return server

    def series(self) -> Path:
        """Series of the abdomen, or of a ball if that is missing."""
        given, folder = data_folder("ct_abdomen_dicom"), self.folder / "series"
        if folder.exists():
            return folder
        if given:
            name_series(given, folder)
        else:
            make_series(folder)
        return folder

    def files(self) -> list[str]:
        """Files of the series."""
        return sorted(str(file) for file in self.series().iterdir())

    def call(self, *arguments: str, status: int = 0, before: str = "", environment: dict[str, str] | None = None,
             timeout: float = 120) -> subprocess.CompletedProcess[str]:
        """Runs the program, which must end with `status`; a failure is one line. `before`: shell command before it."""
        command = [program(), *arguments]
        if before:
            command = ["bash", "-c", before + '\nexec "$0" "$@"', *command]
        done = subprocess.run(command, cwd=self.folder, env={**self.environment, **(environment or {})}, capture_output=True,
                              text=True, timeout=timeout, check=False)
        self.assertEqual(done.returncode, status, f"{arguments}: {done.stdout}{done.stderr}")
        if status:
            self.assertEqual(done.stdout, "")
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertTrue(done.stderr.startswith("simplexseg-cli: "), done.stderr)
        return done

    def json(self, *arguments: str) -> Any:
        """Output of a subcommand of archive with --json."""
        return json.loads(self.call("archive", *arguments, "--json").stdout)

    def cached(self) -> list[Path]:
        """All files and folders in the cache."""
        return sorted(path for path in self.cache.rglob("*") if path.parent != self.cache or not path.is_dir() or
                      path.name.startswith(("incoming", "outgoing")))

    def assert_clean(self) -> None:
        """Checks that no incomplete series remains."""
        self.assertEqual(self.cached(), [])
