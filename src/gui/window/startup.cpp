// SPDX-License-Identifier: Apache-2.0
#include "gui/window/startup.h"

#include <QApplication>
#include <QCommandLineParser>
#include <QFileInfo>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QSurfaceFormat>
#include <QTimer>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "core/freed_memory.h"
#include "gpu/backend.h"
#include "gui/look/theme.h"
#include "gui/window/autosave.h"
#include "gui/window/file_actions.h"
#include "gui/window/look_settings.h"
#include "gui/window/main_window.h"
#include "gui/window/measurement.h"
#include "gui/window/window_memory.h"
#include "gui/workbench/workbench.h"
#include "io/scene_io.h"

namespace simplexseg {
namespace {

constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

struct Options {
  QString input, screenshot, log;
  std::optional<int> steps;
  std::optional<double> measure_s;
  QSize size;
  bool size_given = false;
  std::optional<theme::Choice> theme;
  Backend backend = Backend::Auto;
};

int complain(int status, const QString& text) {
  std::fprintf(stderr, "simplexseg: %s\n", qUtf8Printable(text.simplified()));
  return status;
}

// Without a display Qt aborts with a core file; one line and a status are kinder.
void report_fatal(QtMsgType type, const QMessageLogContext&, const QString& text) {
  static QString cause;
  if (type == QtWarningMsg && text.contains("could not connect to display")) {
    cause = qEnvironmentVariableIsEmpty("DISPLAY") ? "there is no display" : text;
  }
  if (type == QtFatalMsg) {
    std::_Exit(complain(kFailed, "no window can be opened: " + (cause.isEmpty() ? text.section('\n', 0, 0) : cause) +
                                     "; start it where a display is, or use simplexseg-cli, which needs none"));
  }
  if (type == QtCriticalMsg) std::fprintf(stderr, "simplexseg: %s\n", qUtf8Printable(text.simplified()));
}

/// Fills `options`; a status is where the program ends.
std::optional<int> parse(const QStringList& arguments, Options& options) {
  QCommandLineParser parser;
  parser.setApplicationDescription("SimplexSeg: segments medical volumes with live deformable simplex meshes.");
  parser.addPositionalArgument("INPUT", "a scene (.json), a volume, or a folder with a DICOM series", "[INPUT]");
  const QCommandLineOption help({"h", "help"}, "this text"), version({"v", "version"}, "the version");
  const QCommandLineOption backend("backend", "auto, cpu or cuda: what computes", "NAME", "auto");
  const QCommandLineOption screenshot("screenshot", "run the scene, save a picture of the window as PNG, and end",
                                      "FILE");
  const QCommandLineOption steps("steps", "with --screenshot: how many steps; else as many as the scene says", "N");
  const QCommandLineOption size("size", "of the window, as 1280x800", "WxH", "1280x800");
  const QCommandLineOption measure("measure",
                                   "run the scene, drag a point, print frame rate and latency as JSON, and end; with "
                                   "--screenshot a picture at the end too",
                                   "SECONDS");
  const QCommandLineOption log("log", "write the log of all actions at the end", "FILE");
  const QCommandLineOption look("theme", "dark or light, whatever was chosen in the window", "NAME");
  parser.addOptions({help, version, backend, screenshot, steps, size, measure, log, look});
  if (!parser.parse(arguments)) return complain(kBadInput, parser.errorText() + "; see --help");
  if (parser.isSet(help)) {
    std::fputs(qUtf8Printable(parser.helpText().replace("<executable_name>", "simplexseg")), stdout);
    return kDone;
  }
  if (parser.isSet(version)) {
    std::puts("simplexseg " SIMPLEXSEG_VERSION);
    return kDone;
  }
  const QStringList inputs = parser.positionalArguments();
  if (inputs.size() > 1)
    return complain(kBadInput, "more than one input: " + inputs[1] + " is too many; give one scene, volume or folder");
  if (!inputs.isEmpty()) options.input = inputs.front();
  if (!options.input.isEmpty() && !QFileInfo::exists(options.input)) {
    return complain(kBadInput, options.input + ": there is no such file; check the path");
  }
  if (parser.isSet(look)) {
    const QString wanted = parser.value(look);
    if (wanted != "dark" && wanted != "light")
      return complain(kBadInput, "--theme " + wanted + ": there is no such theme; give dark or light");
    options.theme = wanted == "light" ? theme::Choice::Light : theme::Choice::Dark;
  }
  const QString name = parser.value(backend);
  if (name != "auto" && name != "cpu" && name != "cuda") {
    return complain(kBadInput, "--backend " + name + ": there is no such backend; give auto, cpu or cuda");
  }
  if (name == "cpu") options.backend = Backend::Cpu;
  if (name == "cuda") options.backend = Backend::Cuda;
  options.size_given = parser.isSet(size);
  const QStringList sides = parser.value(size).split('x');
  if (sides.size() == 2) options.size = QSize(sides[0].toInt(), sides[1].toInt());
  if (options.size.width() < 640 || options.size.height() < 480 || options.size.width() > 16384 ||
      options.size.height() > 16384) {
    return complain(kBadInput,
                    "--size " + parser.value(size) + ": not a size of at least 640x480; give it as 1280x800");
  }
  options.screenshot = parser.value(screenshot);
  options.log = parser.value(log);
  if (parser.isSet(screenshot) && options.screenshot.isEmpty())
    return complain(kBadInput, "--screenshot: no file is named; give one");
  if (parser.isSet(measure)) {
    bool good = false;
    options.measure_s = parser.value(measure).toDouble(&good);
    if (!good || !(*options.measure_s > 0 && *options.measure_s <= 3600)) {
      return complain(kBadInput,
                      "--measure " + parser.value(measure) + ": not a number of seconds up to 3600; give one");
    }
    if (options.input.isEmpty() || parser.isSet(steps))
      return complain(kBadInput, "--measure: it needs a scene, and no --steps; give a scene alone");
  }
  if (parser.isSet(steps)) {
    bool good = false;
    options.steps = parser.value(steps).toInt(&good);
    if (!good || *options.steps < 0) {
      return complain(kBadInput,
                      "--steps " + parser.value(steps) + ": not a number of steps; give a whole number from 0");
    }
    if (options.screenshot.isEmpty())
      return complain(kBadInput, "--steps: it needs --screenshot; give a file for the picture");
  }
  return std::nullopt;
}

std::filesystem::path to_path(const QString& text) { return std::filesystem::path(text.toStdU16String()); }

int fail(const std::exception& error, int status) { return complain(status, QString::fromUtf8(error.what())); }

/// A status is where the program ends.
std::optional<int> load(MainWindow& window, const Options& options) {
  window.set_unattended();
  try {
    if (!options.input.isEmpty()) window.files().take(load_input(to_path(options.input)), to_path(options.input));
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
  window.show();
  return std::nullopt;
}

int save_screenshot(QApplication& application, MainWindow& window, const Options& options) {
  // Layout and painting settle within a few rounds of events.
  for (int round = 0; round < 10; ++round) application.processEvents(QEventLoop::AllEvents, 50);
  try {
    window.save_picture(options.screenshot);
  } catch (const std::exception& error) {
    return fail(error, kFailed);
  }
  return kDone;
}

int take_screenshot(QApplication& application, MainWindow& window, const Options& options) {
  if (const std::optional<int> status = load(window, options)) return *status;
  // A scene without a number of steps goes until it rests; the bound is for one that never does.
  constexpr int kUntilRest = 5000;
  const int wanted = options.steps.value_or(window.workbench().scene().steps);
  const bool until_rest = !options.steps && wanted == 0;
  int left = until_rest ? kUntilRest : wanted;
  while (left > 0 && !window.workbench().scene().meshes.empty()) {
    const Advance done = window.workbench().advance_steps(std::min(left, 20), until_rest);
    left -= done.steps;
    if (done.failure) return complain(kFailed, QString::fromStdString(*done.failure));
    if (done.steps == 0 || (until_rest && done.at_rest)) break;
  }
  return save_screenshot(application, window, options);
}

int measure_window(QApplication& application, MainWindow& window, const Options& options) {
  if (const std::optional<int> status = load(window, options)) return *status;
  try {
    std::fputs(measure(window, *options.measure_s).constData(), stdout);
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
  return options.screenshot.isEmpty() ? kDone : save_screenshot(application, window, options);
}

int run_window(QApplication& application, MainWindow& window, const Options& options, const std::string& note) {
  WindowMemory memory(window);
  Autosave autosave(window.workbench(), window.files(), window.job(), window, Autosave::default_root());
  if (!options.size_given) memory.restore_geometry();
  window.show();
  if (!note.empty()) window.workbench().say(Severity::Note, QString::fromStdString(note));
  if (!options.input.isEmpty()) QTimer::singleShot(0, &window, [&] { window.files().open(options.input); });
  QTimer::singleShot(0, &autosave, &Autosave::offer);
  return application.exec();
}

}  // namespace

void set_surface_format() {
  QSurfaceFormat format;
  format.setRenderableType(QSurfaceFormat::OpenGL);
  format.setVersion(4, 5);
  format.setProfile(QSurfaceFormat::CoreProfile);
  format.setDepthBufferSize(24);
  format.setStencilBufferSize(8);
  QSurfaceFormat::setDefaultFormat(format);
  // The views draw from the same buffers.
  QCoreApplication::setAttribute(Qt::AA_ShareOpenGLContexts);
}

std::string why_no_opengl() {
  // Qt 6.4 hands out contexts on these and then crashes when it composes a window from them.
  const QString platform = QGuiApplication::platformName();
  if (platform == "offscreen" || platform == "minimal")
    return "Qt's platform '" + platform.toStdString() + "' has none";
  QOffscreenSurface surface;
  surface.setFormat(QSurfaceFormat::defaultFormat());
  surface.create();
  QOpenGLContext context;
  context.setFormat(QSurfaceFormat::defaultFormat());
  if (!surface.isValid() || !context.create() || !context.makeCurrent(&surface)) return "no OpenGL context can be made";
  const QSurfaceFormat got = context.format();
  if (got.version() < qMakePair(4, 5)) {
    return "the driver offers OpenGL " + std::to_string(got.majorVersion()) + "." + std::to_string(got.minorVersion());
  }
  return {};
}

int run_desktop(int argc, char** argv) {
  keep_freed_memory();
  QStringList arguments;
  for (int n = 0; n < argc; ++n) arguments << QString::fromLocal8Bit(argv[n]);
  Options options;
  if (const std::optional<int> status = parse(arguments, options)) return *status;

  qInstallMessageHandler(report_fatal);
  set_surface_format();
  QApplication application(argc, argv);
  QApplication::setApplicationName("SimplexSeg");
  // Pictures for others do not depend on whose desktop they are made on.
  std::optional<LookSettings> look;
  const bool for_a_user = options.screenshot.isEmpty() && !options.measure_s;
  if (for_a_user)
    look.emplace(application, options.theme);
  else
    theme::apply(application, options.theme.value_or(theme::Choice::Dark) != theme::Choice::Light);
  if (const std::string why = why_no_opengl(); !why.empty()) {
    return complain(kFailed, "OpenGL 4.5 is needed for the window: " + QString::fromStdString(why) +
                                 "; update the graphics driver or Mesa, or use simplexseg-cli, which works without it");
  }
  EngineChoice choice;
  try {
    choice = make_engine(options.backend);
  } catch (const std::exception& error) {
    return complain(kFailed, QString::fromUtf8(error.what()));
  }
  MainWindow window(std::move(choice.engine), std::move(choice.spare));
  window.workbench().learn_fields_with(std::move(choice.fields));
  window.set_engine_maker([backend = options.backend] { return make_engine(backend).engine; });
  window.resize(options.size);
  if (look) {
    look->fill(*window.view_menu());
    QObject::connect(&*look, &LookSettings::said, &window,
                     [&window](const QString& text) { window.workbench().say(Severity::Note, text); });
  }
  int status = kDone;
  if (options.measure_s) {
    status = measure_window(application, window, options);
  } else if (!options.screenshot.isEmpty()) {
    status = take_screenshot(application, window, options);
  } else {
    status = run_window(application, window, options, choice.note);
  }
  if (status == kDone && !options.log.isEmpty()) {
    try {
      const Session& session = window.workbench().session();
      write_log(to_path(options.log), session.log(), session.steps_since_last_command());
    } catch (const std::exception& error) {
      return complain(kFailed, QString::fromUtf8(error.what()));
    }
  }
  return status;
}

}  // namespace simplexseg
