// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QTimer>
#include <string>
#include <vector>

namespace simplexseg {

/// Lines that may come with every frame, told as one message every few seconds: the latest, and how many came with it.
class RepeatedWarning : public QObject {
  Q_OBJECT
 public:
  explicit RepeatedWarning(int interval_ms = 3000, QObject* parent = nullptr);
  void add(const std::vector<std::string>& lines);
  /// What has not been told is dropped; the next line is told at once.
  void forget();

 signals:
  void tell(const QString& text);

 private:
  void tell_now();

  QTimer pause_;
  QString latest_;
  int untold_ = 0;
};

}  // namespace simplexseg
