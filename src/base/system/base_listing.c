/* SPDX-License-Identifier: GPL-3.0-or-later
 * The entries of a folder: the layout of `struct dirent` is known to C alone. See base_listing.f90. */
#include <dirent.h>
#include <string.h>

/* Copies the name of the next entry, with its final zero; 0 if there is none, or it does not fit. */
int flusi_next_entry(void *folder, char *name, int size)
{
    struct dirent *entry = readdir((DIR *)folder);
    if (!entry || strlen(entry->d_name) >= (size_t)size)
        return 0;
    strcpy(name, entry->d_name);
    return 1;
}
