// A plugin of QEMU (qemu-user, "TCG plugins") that counts the instructions that a program executes, for processors on
// which valgrind cannot run here. At the program's end it prints a line as callgrind does: "totals: N".
//
// The declarations are those of QEMU's qemu-plugin.h that it needs, version 1 of that interface.
#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>

extern "C" {

struct qemu_plugin_tb;
using PluginId = uint64_t;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };

std::size_t qemu_plugin_tb_n_insns(const qemu_plugin_tb* block);
void qemu_plugin_register_vcpu_tb_trans_cb(PluginId id, void (*translated)(PluginId, qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_cb(qemu_plugin_tb* block, void (*executed)(unsigned, void*),
                                          qemu_plugin_cb_flags flags, void* instructions);
void qemu_plugin_register_atexit_cb(PluginId id, void (*ended)(PluginId, void*), void* nothing);

[[gnu::visibility("default")]] extern int qemu_plugin_version;
int qemu_plugin_version = 1;

[[gnu::visibility("default")]] int qemu_plugin_install(PluginId id, const void* system, int count, char** arguments);
}

namespace {

uint64_t executed = 0;  // of a program with one thread

void count(unsigned, void* instructions) { executed += reinterpret_cast<uintptr_t>(instructions); }

void translate(PluginId, qemu_plugin_tb* block) {
    const auto instructions = static_cast<uintptr_t>(qemu_plugin_tb_n_insns(block));
    qemu_plugin_register_vcpu_tb_exec_cb(block, count, QEMU_PLUGIN_CB_NO_REGS, reinterpret_cast<void*>(instructions));
}

void report(PluginId, void*) { std::fprintf(stderr, "totals: %" PRIu64 "\n", executed); }

}  // namespace

int qemu_plugin_install(PluginId id, const void*, int, char**) {
    qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
    qemu_plugin_register_atexit_cb(id, report, nullptr);
    return 0;
}
