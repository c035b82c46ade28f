/* SPDX-License-Identifier: GPL-3.0-or-later
 * A child process: the environment and the encoding of how a process ended are known to C alone. See base_child.f90. */
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/types.h>
#include <sys/wait.h>

extern char **environ;

/* Runs a program with two arguments, without input and output, and waits for its end. Its exit code; 256 + N if signal N ended
 * it; -1 if it did not start. posix_spawn copies no memory, so that a process under MPI may call it. */
int flusi_run_child(const char *program, const char *first, const char *second)
{
    char *arguments[] = {(char *)program, (char *)first, (char *)second, 0};
    posix_spawn_file_actions_t actions;
    pid_t child;
    int i, status, error;

    if (posix_spawn_file_actions_init(&actions))
        return -1;
    for (i = 0; i < 3; i++)
        posix_spawn_file_actions_addopen(&actions, i, "/dev/null", i == 0 ? O_RDONLY : O_WRONLY, 0);
    error = posix_spawn(&child, program, &actions, 0, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error)
        return -1;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return -1;
    return WIFSIGNALED(status) ? 256 + WTERMSIG(status) : WEXITSTATUS(status);
}
