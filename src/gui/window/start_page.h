// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QVBoxLayout;

namespace simplexseg {

class ActionTable;

/// Page over the views while no volume is open; offers to open one.
class StartPage : public QWidget {
  Q_OBJECT
 public:
  StartPage(ActionTable& actions, QWidget* over);
  /// Lists recently opened files, latest first; missing files are left out.
  void show_recent(const QStringList& paths);

 signals:
  void open_requested(const QString& path);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void add_path(const QString& title, const QString& path);

  QWidget* recent_ = nullptr;
  QVBoxLayout* recent_column_ = nullptr;
};

}  // namespace simplexseg
