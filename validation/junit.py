"""The verdicts as JUnit XML, for the build servers that read it."""

from __future__ import annotations

from pathlib import Path

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from validation.plain_text import plain
from validation.record import BROKEN, FAILS, NOT_RUN, Report, write_whole
from validation.terminal import again


def write_junit(report: Report, path: Path) -> None:
    """Write a test suite a family and a test case a claim; what XML cannot hold is escaped."""
    xml = JUnitXml("softbody validation")
    for family in dict.fromkeys(claim.family for claim in report.claims):
        suite = TestSuite(plain(family))
        for claim in report.claims:
            if claim.family != family:
                continue
            case = TestCase(plain(claim.id), classname=plain(f"validation.{claim.family}"), time=claim.seconds)
            repeat = f"\n{again(claim, report.level)}"
            if claim.verdict == FAILS:
                kind = Failure if claim.value is not None else Error
                case.result = [kind(plain(f"{claim.claim}: {claim.why}{repeat}"))]
            elif claim.verdict == BROKEN:
                case.result = [Error(plain(f"engine broken: {claim.why}{repeat}"))]
            elif claim.verdict == NOT_RUN:
                case.result = [Skipped(plain(claim.why or ""))]
            suite.add_testcase(case)
        xml.add_testsuite(suite)
    xml.update_statistics()
    write_whole(path, xml.tostring().decode("utf-8"))
