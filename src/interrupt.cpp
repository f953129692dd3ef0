// SPDX-License-Identifier: MIT
#include "interrupt.hpp"

#include <csignal>

namespace slice2mesh_program {

namespace {

volatile std::sig_atomic_t asked_to_stop = 0;

extern "C" void note_signal(int signal) {
  asked_to_stop = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void note_signals() {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
#ifdef SIGXFSZ
  std::signal(SIGXFSZ, SIG_IGN);
#endif
}

bool interrupted() noexcept {
  return asked_to_stop != 0;
}

void stop_if_interrupted(slice2mesh::Stage stage) {
  if (interrupted()) throw slice2mesh::Cancelled(stage);
}

}  // namespace slice2mesh_program
