/* SPDX-License-Identifier: GPL-3.0-or-later
 * Which signals were ignored when the program began. Libraries may catch signals as soon as they are loaded, as UCX does with SIGHUP,
 * and nobody could tell afterwards: so this looks before they are set up. See base_signals.f90. */
#include <signal.h>

enum { N_SIGNALS = 32 };
static char was_ignored[N_SIGNALS];

static void look(void)
{
    struct sigaction now;
    for (int number = 1; number < N_SIGNALS; number++)
        was_ignored[number] = sigaction(number, 0, &now) == 0 && now.sa_handler == SIG_IGN;
}

#ifdef __linux__
__attribute__((section(".preinit_array"), used)) static void (*look_first)(void) = look;
#else
__attribute__((constructor)) static void look_early(void) { look(); }
#endif

/* 1 if the signal `number` was ignored, else 0. */
int flusi_was_ignored(int number)
{
    return number > 0 && number < N_SIGNALS && was_ignored[number];
}
