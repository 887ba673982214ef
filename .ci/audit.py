"""Known vulnerabilities of what is installed, by pip-audit.

    python .ci/audit.py PIP_AUDIT SITE_PACKAGES

asks PyPI, then OSV. Exit code 1 where a package has a known vulnerability that is mended in a later version or not at
all; 0 where none has; 3 where the data cannot be had, for all packages or for some, in a line that says so.
"""

import json
import subprocess
import sys

SERVICES = ("pypi", "osv")
CLEAN, VULNERABLE, UNKNOWN = 0, 1, 3


def verdict(report):
    """(exit code, lines) of what pip-audit wrote as JSON; None where it wrote nothing."""
    packages = report["dependencies"] if report else []
    # The project itself is nowhere to be looked up
    packages = [package for package in packages if package["name"] != "snowmpm"]
    audited = [package for package in packages if "skip_reason" not in package]
    found = [f"{package['name']} {package['version']}: {one['id']}"
             + (f", mended in {', '.join(one['fix_versions'])}" if one.get("fix_versions") else ", not mended yet")
             for package in audited for one in package["vulns"]]
    if found:
        return VULNERABLE, found
    if len(audited) < len(packages) or not packages:
        return UNKNOWN, [f"skipped: vulnerability data could be had for {len(audited)} of {len(packages)} packages"]
    return CLEAN, [f"no known vulnerability in {len(audited)} packages"]


def ask(pip_audit, where, service):
    """What pip-audit finds of the packages in a folder, or None."""
    command = [pip_audit, "--path", where, "--vulnerability-service", service, "--format", "json",
               "--progress-spinner", "off", "--timeout", "15"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
    try:
        return json.loads(done.stdout)
    except ValueError:
        reason = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
        print(f"{service}: {reason[:300]}")
        return None


def main(pip_audit, where):
    """Exit code of the first service that knows everything, else of the one that knows most."""
    for service in SERVICES:
        code, lines = verdict(ask(pip_audit, where, service))
        print(*(f"{service}: {line}" for line in lines), sep="\n")
        if code != UNKNOWN:
            return code
    return UNKNOWN


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
