//! Exact throughput of product-form networks, by two independent recursions.

use gpumodel::queueing::Network;

/// Mean value analysis (Reiser and Lavenberg 1980) of single-server stations.
pub(crate) fn mva(network: &Network) -> f64 {
    assert!(
        network.stations.iter().all(|station| station.servers == 1),
        "MVA here knows single servers only"
    );
    let mut queues = vec![0.0; network.stations.len()];
    let mut throughput = 0.0;
    for customers in 1..=network.customers as u32 {
        let responses: Vec<f64> = network
            .stations
            .iter()
            .zip(&queues)
            .map(|(station, queue)| station.demand * (1.0 + queue))
            .collect();
        throughput = f64::from(customers) / (network.think_time + responses.iter().sum::<f64>());
        queues = responses.iter().map(|response| throughput * response).collect();
    }
    throughput
}

/// The convolution algorithm (Buzen 1973), stations with any number of servers. Only sums of positive terms.
pub(crate) fn convolution(network: &Network) -> f64 {
    let customers = network.customers as usize;
    let scale = network.stations.iter().map(|station| station.demand).fold(network.think_time, f64::max);
    let weights = |demand: f64, servers: f64| -> Vec<f64> {
        let mut weights = vec![1.0];
        for present in 1..=customers {
            weights.push(weights[present - 1] * demand / scale / servers.min(present as f64));
        }
        weights
    };
    let mut constants = weights(network.think_time, f64::INFINITY);
    for station in &network.stations {
        let own = weights(station.demand, f64::from(station.servers));
        constants =
            (0..=customers).map(|n| (0..=n).map(|here| own[here] * constants[n - here]).sum()).collect();
    }
    constants[customers - 1] / constants[customers] / scale
}
