// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QSettings>
#include <QString>

namespace simplexseg {

/// Keys that the user has changed, kept between runs of the program as differences from the defaults. Not used in runs
/// without a user.
class KeySettings : public QObject {
 public:
  /// Applies the stored keys to KeyMap::shared() and stores them whenever they change.
  KeySettings();
  /// Why the stored keys cannot be used, in which case the defaults apply and the stored ones stay until a key is
  /// changed; empty if they can.
  const QString& fault() const { return fault_; }

 private:
  QSettings settings_;
  QString fault_;
};

}  // namespace simplexseg
