// SPDX-License-Identifier: Apache-2.0
#include "archive/receiver.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "archive/faults.h"
#include "io/dicom/dicom_identity.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

ArchiveFault cannot_write(const fs::path& path, int reason) {
  const fs::path folder = path.parent_path();
  return ArchiveFault(write_error("cannot store received files in " + quoted(folder), folder, reason).what());
}

}  // namespace

ReceivedFile::~ReceivedFile() {
  if (is_open()) ::close(descriptor_);
}

void ReceivedFile::open(const fs::path& path) {
  path_ = path;
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (!is_open()) throw cannot_write(path, errno);
}

void ReceivedFile::write(const char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t done = ::write(descriptor_, data, bytes);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) throw cannot_write(path_, done < 0 ? errno : ENOSPC);
    data += done;
    bytes -= static_cast<std::size_t>(done);
  }
}

void ReceivedFile::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) throw cannot_write(path_, errno);
}

SeriesReceiver::SeriesReceiver(const ArchiveServer& server, const ArchiveCache& cache, const std::string& series,
                               const std::set<std::string>& expected, const ArchiveProgress& progress)
    : server_(server),
      cache_(cache),
      series_(series),
      expected_(expected),
      progress_(progress),
      incoming_(cache, cache.folder_of(server, series)) {
  transfer_.total = static_cast<int>(expected.size());
  report_progress(progress_, transfer_);
}

fs::path SeriesReceiver::next_file() { return incoming_.folder() / ("part-" + std::to_string(files_++)); }

void SeriesReceiver::count(std::uint64_t bytes) {
  transfer_.bytes += bytes;
  if (transfer_.bytes > cache_.limit())
    throw too_large(server_, "the series", cache_.limit(), "raise the limit of the cache");
  report_progress(progress_, transfer_);
}

void SeriesReceiver::add(const fs::path& file) {
  DicomIdentity identity;
  try {
    identity = read_dicom_identity(file);
  } catch (const Error& error) {
    std::string why = error.what();  // without the name of the temporary file and without the remedy
    why = why.substr(0, why.rfind(';'));
    throw archive_fault(server_, "an instance is damaged: " + why.substr(std::min(why.rfind("': ") + 3, why.size())),
                        "fetch it again");
  }
  const char* const remedy = kAskAdministrator;
  if (identity.series != series_ || expected_.count(identity.sop_instance) == 0 || !is_dicom_uid(identity.sop_instance))
    throw archive_fault(server_, "it sent an instance that does not belong to the series", remedy);
  if (!received_.insert(identity.sop_instance).second)
    throw archive_fault(server_, "it sent an instance twice", remedy);
  std::error_code failure;
  fs::rename(file, incoming_.folder() / (identity.sop_instance + ".dcm"), failure);
  if (failure) throw cannot_write(file, failure.value());
  ++transfer_.instances;
  report_progress(progress_, transfer_);
}

fs::path SeriesReceiver::finish() {
  if (received_.size() < expected_.size())
    throw archive_fault(server_,
                        "incomplete series: " + std::to_string(received_.size()) + " of " +
                            std::to_string(expected_.size()) + " instances arrived",
                        "fetch it again");
  fs::path folder = incoming_.commit();
  cache_.make_room(0, folder);
  return folder;
}

}  // namespace simplexseg
