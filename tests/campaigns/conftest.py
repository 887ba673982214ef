"""Two workers for all tests of campaigns, which are started when the first test wants them."""

import pytest


@pytest.fixture(scope="package")
def site():
    """`snowmpm.campaigns.cluster.Site` of two processes."""
    pytest.importorskip("distributed")
    from snowmpm.campaigns import cluster
    from snowmpm.campaigns.spec import Cluster

    with cluster.site(Cluster(workers=2)) as found:
        yield found
