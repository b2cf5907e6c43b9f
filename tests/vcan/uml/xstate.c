/* Lets User-Mode-Linux 6.1 run on processors with AMX. Loaded in front of it (LD_PRELOAD) by boot.sh.
 *
 * It keeps 2696 bytes of the registers of each process, up to PKRU. The host's kernel takes them only whole
 * (-EFAULT otherwise), and with AMX they are 11 008 bytes. Here the rest is put behind them and marked as being in its
 * initial state, which is right, because no process has AMX without asking for it. Linux 6.13 needs no such help. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#define HEADER 512       /* offset of XSTATE_BV, the set of components that are not in their initial state */
#define UP_TO_PKRU 0x3ff /* components whose place lies within what User-Mode-Linux keeps */

static char whole[1 << 16] __attribute__((aligned(64)));
static size_t size; /* of all registers, as the kernel told */

static long get(pid_t pid, struct iovec *asked) {
  struct iovec all = {whole, sizeof whole};
  long result = syscall(SYS_ptrace, PTRACE_GETREGSET, pid, NT_X86_XSTATE, &all);
  if (result < 0) return result;
  size = all.iov_len;
  if (asked->iov_len > size) asked->iov_len = size;
  memcpy(asked->iov_base, whole, asked->iov_len);
  return result;
}

static long set(pid_t pid, const struct iovec *given) {
  struct iovec all = {whole, size > given->iov_len ? size : given->iov_len};
  memset(whole, 0, all.iov_len);
  memcpy(whole, given->iov_base, given->iov_len);
  if (all.iov_len > given->iov_len) *(uint64_t *)(whole + HEADER) &= UP_TO_PKRU;
  return syscall(SYS_ptrace, PTRACE_SETREGSET, pid, NT_X86_XSTATE, &all);
}

long ptrace(enum __ptrace_request request, ...) {
  static long (*next)(enum __ptrace_request, ...);
  va_list rest;
  va_start(rest, request);
  pid_t pid = va_arg(rest, pid_t);
  void *addr = va_arg(rest, void *);
  void *data = va_arg(rest, void *);
  va_end(rest);
  if (addr == (void *)NT_X86_XSTATE && request == PTRACE_GETREGSET) return get(pid, data);
  if (addr == (void *)NT_X86_XSTATE && request == PTRACE_SETREGSET) return set(pid, data);
  if (!next) next = dlsym(RTLD_NEXT, "ptrace");
  return next(request, pid, addr, data);
}
